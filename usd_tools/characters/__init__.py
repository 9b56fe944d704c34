"""Characters as they are drawn: meshes that move with joints, their colours, and where they stand."""
