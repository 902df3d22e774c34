"""Who is measured: ourselves and others, each in a process of its own (`python -m` this package).

A contestant is a function from its work to a function that does so many pieces of it. What a
contestant needs beyond the plain install it imports itself; one that is not there is reported.
"""
