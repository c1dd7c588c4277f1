"""A point in the plane that moves as it is told, towards a goal that it is not shown; plain NumPy."""
