"""How policies learn from batches of experience, and the loop that all share."""
