"""Parameters of derivatives, and derivatives of the construction of the model."""
