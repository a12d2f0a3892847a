"""Laws: functions of one variable, as formulas, tables and Python functions, and parameters that formulas compute."""
