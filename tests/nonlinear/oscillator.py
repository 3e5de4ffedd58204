"""A linear oscillator, whose steady state is known in closed form."""

from chassym.derivation import (
    ForceLaw,
    Linear,
    Mechanism,
    Model,
    PointAcceleration,
    PointDisplacement,
    TravelPort,
    build_model,
    prismatic,
)


def oscillator(stiffness: float = 800.0, damping: float = 6.0, law: ForceLaw | None = None) -> Model:
    """Two kilograms on a spring, a damper and perhaps a third element, whose foot moves."""
    mechanism = Mechanism("oscillator", gravity=0)
    mass = mechanism.add_body("mass", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=2.0)
    point = mechanism.point("foot", mass, (0, 0, 0))
    port = TravelPort(point, mechanism.ground, "z").less(mechanism.add_input("road", "m"))
    mechanism.add_force_element("spring", port, Linear(stiffness, damping))
    if law is not None:
        mechanism.add_force_element("third", port, law)
    mechanism.add_output(PointDisplacement("displacement", point, "z", mechanism.ground))
    mechanism.add_output(PointAcceleration("acceleration", point, "z", mechanism.ground))
    return build_model(mechanism, {})
