"""Many runs of one scenario, each from a start of its own with disturbances of its own, and what they show together.

The data flow in one direction, one idea a file:

    Sweep, number -> Drawn -> Outcome -> Journal -> Summary -> table, JSON, picture

Every run depends on its seed and its number alone, so neither the number of workers nor interruptions change a result.
"""
