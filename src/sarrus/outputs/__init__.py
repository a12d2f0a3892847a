"""Outputs: what a name such as "slider.x", "pin.force.z", "spring.tension" or "energy.total" is along a motion.

Every analysis, study, plot, table and the shell take their names from here. Formulas of mechanics are in the elements;
what is made of outputs, such as responses and events, is in the analyses.
"""
