"""What derivatives are taken with respect to, and the construction of the model, differentiated."""
