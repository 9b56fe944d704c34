"""The page of `live`: characters that play, and controls that bend their in-betweens."""
