"""What is checked of a model before anything is blamed on the machine."""
