"""Contact events."""

from typing import NamedTuple

__all__ = ["Event"]


class Event(NamedTuple):
    """A contact event in `Result.events`."""

    time_s: float
    """Time of the event, s."""
    contact: str
    """Name of the contact: for a finger "proximal", "distal" or "limit"; for discs such as "hammer-anvil"."""
    kind: str
    """ "touch-down", "lift-off", "pressed again", "begins to slip" or "sticks again"."""
    approach_speed: float
    """Approach speed at a touch-down, m/s (for a joint limit rad/s); 0 for other events."""
    impulse: float
    """At a lift-off, normal impulse since the last touch-down, N·s (for a joint limit N·m·s); 0 for other events."""
