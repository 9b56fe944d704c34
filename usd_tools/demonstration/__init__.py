"""The work of `demo`: a clip, few of its samples, and what is made of them."""
