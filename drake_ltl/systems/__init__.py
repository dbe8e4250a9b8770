"""LeafSystems: the navigation field, the controllers and the supervisor that switches them."""
