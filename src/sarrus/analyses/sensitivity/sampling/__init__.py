"""States of a run at any time, consistent and as they are reported, with their derivatives."""
