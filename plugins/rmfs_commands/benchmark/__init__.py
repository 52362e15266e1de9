"""The benchmark set: frozen instances, best known values with what makes them again, and a search for better ones."""
