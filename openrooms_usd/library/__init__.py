"""Furniture, materials and environments: made by rules, published as USD assets."""
