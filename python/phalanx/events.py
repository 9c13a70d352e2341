"""Changes of contact."""

from typing import NamedTuple

__all__ = ["Event"]


class Event(NamedTuple):
    """A change of contact, as `Result.events` lists them."""

    time_s: float
    """When, in s."""
    contact: str
    """Where: "proximal", "distal", "limit" of a finger, "hammer-anvil" of discs, …"""
    kind: str
    """ "touch-down", "lift-off", "pressed again", "begins to slip" or "sticks again"."""
    approach_speed: float
    """Closing speed at a touch-down, in m/s (of a joint limit rad/s); 0 otherwise."""
    impulse: float
    """Normal impulse since the last touch-down, at a lift-off, in N·s (of a joint limit N·m·s); 0 otherwise."""
