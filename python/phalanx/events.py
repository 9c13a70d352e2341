"""Contact events."""

from typing import NamedTuple

__all__ = ["Event"]


class Event(NamedTuple):
    """A contact event in `Result.events`."""

    time_s: float
    """Time of the event, s."""
    contact: str
    """Name of the contact: "proximal", "distal", "limit" of a finger, "hammer-anvil" of discs, …"""
    kind: str
    """ "touch-down", "lift-off", "pressed again", "begins to slip" or "sticks again"."""
    approach_speed: float
    """Approach speed at a touch-down, m/s (for a joint limit rad/s); 0 for other events."""
    impulse: float
    """Normal impulse since the last touch-down, at a lift-off, N·s (for a joint limit N·m·s); 0 for other events."""
