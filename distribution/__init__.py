"""What a release is made with: wheels that hold compiled kernels."""
