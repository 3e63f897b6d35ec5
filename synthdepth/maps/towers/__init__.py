"""City buildings of 3 to 60 storeys: façades, shop fronts, balconies, roofs."""
