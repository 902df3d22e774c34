"""How a person drives the mountain car: swing high on the left, then run up to the flag."""


def drive(generator):
    """Begin an episode; what is returned acts in it, from (position, velocity) to a force."""
    swung = False

    def act(observation):
        nonlocal swung
        position, velocity = observation
        swung = swung or position < -0.8
        if not swung and position > 0.1:
            return [-1.0]  # not up to the flag yet
        return [0.8 if velocity > 0 else -0.8]

    return act
