"""Elements sorted by class, the sparsity of every operator, and the places of its entries."""
