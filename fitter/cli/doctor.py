"""`brdf doctor`: what this machine offers, and what to install."""

from __future__ import annotations

import click


@click.command(name="doctor")
@click.pass_context
def command(ctx: click.Context) -> None:
    """Shows versions, the JAX devices and the OpenGL context that the preview would use, and what to install.

    Exit status 1 if fits or previews cannot run here.

    \b
    Example:
      brdf doctor
    """
    import importlib.metadata as metadata
    import platform

    click.echo(f"brdf-fitter    {metadata.version('brdf-fitter')}")
    click.echo(f"python         {platform.python_version()} on {platform.system()} {platform.machine()}")
    for package in ("jax", "equinox", "optimistix", "numpy", "moderngl", "OpenEXR"):
        click.echo(f"{package:14} {metadata.version(package)}")
    import jax

    devices = ", ".join(f"{device.platform}:{device.id} {device.device_kind}" for device in jax.devices())
    click.echo(f"jax devices    {devices}")
    import brdf
    from shaders.context import describe

    wi = jax.numpy.array([[0.0, 0.6, 0.8]])
    fits = bool(jax.numpy.isfinite(brdf.evaluate(brdf.build("lambert+ggx"), wi, wi)).all())

    opengl = describe()
    for attempt in opengl["tried"]:
        click.echo(f"{'opengl tried':14} {attempt}")
    if opengl["available"]:
        kind = "software" if opengl["software"] else "hardware"
        place = "" if opengl["device_index"] is None else f", device {opengl['device_index']}"
        click.echo(f"opengl         {opengl['version']}")
        click.echo(f"renderer       {opengl['renderer']} ({kind}, {opengl['backend']}{place})")
        for name, value in opengl["limits"].items():
            click.echo(f"{'':14} {name} {value}")
    click.echo("fits           " + ("ok" if fits else "not possible: JAX gives no finite number here"))
    click.echo("previews       " + ("ok" if opengl["available"] else f"not possible: {opengl['problem']}"))
    if not (fits and opengl["available"]):
        ctx.exit(1)
