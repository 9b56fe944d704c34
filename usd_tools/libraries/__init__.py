"""Libraries of in-betweens: learned from clips, and used for others."""
