"""The scenario from which people begin to write their own: small, complete, every line explained."""

STARTER = """\
# Two robots carry a crate from the depot to the dock and back, for ever. Change what you like, then:
#
#     drake-ltl check FILE       are there mistakes?
#     drake-ltl draw FILE        a map of it as map.png
#     drake-ltl plan FILE        who does what in which step
#     drake-ltl simulate FILE    the mission carried out and judged; --record page.html to watch it
#
# Lengths in m, angles in rad, positions in the world frame: x and y on the floor, z up from it.
# Names of regions and members stand in formulas: lower-case letters, digits and underscores.
name: errand

workspace: {radius: 16.0}            # a ball around the origin; everything happens inside it

regions:                             # balls that may not overlap: a step of a plan leads from one to another
  depot: {centre: [-8.0, 0.0, 0.0], radius: 4.0}
  dock: {centre: [8.0, 0.0, 0.0], radius: 4.0}

agents:                              # robots
  a1:
    model: package://drake_ltl_models/agents/planar_arm.urdf   # or the path of a URDF, from this file's folder
    position: [-5.5, 1.5]            # of its base; its bounding sphere must lie in a region
    heading: 0.0                     # of its arm; robots 2 pi / 3 apart grip firmly together
    power: 2                         # what it adds to a team that carries
  a2:
    model: package://drake_ltl_models/agents/planar_arm.urdf
    position: [8.0, 0.0]
    heading: 2.0944
    power: 2
    spec: "GF dock"                  # it is in the dock again and again

objects:
  crate:
    model: package://drake_ltl_models/objects/crate.sdf
    position: [-8.5, 0.0]
    power_needed: 4                  # the powers of those who carry it must add up to this: here both
    spec: "GF dock & GF depot"       # it is in the dock again and again, and in the depot

# Formulas are linear temporal logic over the regions in which a member is, one letter per step of the plan:
#     ! not   & and   | or   -> if .. then   <-> if and only if
#     F at some time   G always   X in the next step   U until   GF again and again   FG from some time on
# A member's own formula (spec) names regions; the one for all (below) names member.region.
spec: "G !(a1.dock & crate.depot)"   # while the crate is in the depot, a1 is not in the dock
"""
"""YAML; see `drake_ltl.scenario.load`."""
