"""What goes wrong on purpose, how it is noticed, and how a mission goes on.

`injection` is the hand that breaks things; `losses` says what a detected fault takes away; recovery itself is in
`drake_ltl.execution.recovery`. Monitors (`drake_ltl.systems.fault_monitors`) see measured signals alone.
"""
