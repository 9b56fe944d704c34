"""Points that are planted on the ground: found in motion or in keys, measured, and kept where they are."""

from geomstats_anim.contacts.detection import ContactParameters, Contacts, find_contacts
from geomstats_anim.contacts.planting import Planted, Plants, plant
from geomstats_anim.contacts.skating import Skating, skating

__all__ = [
    "ContactParameters",
    "Contacts",
    "Planted",
    "Plants",
    "Skating",
    "find_contacts",
    "plant",
    "skating",
]
