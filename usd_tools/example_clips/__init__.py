"""The five example clips: a 24-joint biped with a skin, and its motions as key poses."""
