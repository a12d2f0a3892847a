"""Integrators: what starts and continues a run by one method, or by a solver of another library."""
