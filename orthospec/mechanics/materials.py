"""Elastic constants, densities and yield strengths of the materials that bars are made of.

>>> TABLE["steel"].E / 1e9
210.0
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple


class Material(NamedTuple):
    """A material of bars, linear and isotropic but for G: along the bar's axis where it is not."""

    E: float
    """Young's modulus [Pa]."""
    G: float
    """Shear modulus [Pa]."""
    density: float | None = None
    """Density [kg/m^3]."""
    yield_strength: float | None = None
    """Yield or 0.2 % proof strength [Pa]."""


def shear_modulus(E: float, *, nu: float) -> float:
    """G = E / (2 (1 + ν)) of an isotropic material [Pa]."""
    return E / (2 * (1 + nu))


TABLE: Mapping[str, Material] = MappingProxyType(
    {
        "steel": Material(210e9, shear_modulus(210e9, nu=0.3), 7850.0, 355e6),
        "aluminium": Material(70e9, shear_modulus(70e9, nu=0.3), 2700.0, 250e6),
        "titanium": Material(113.8e9, shear_modulus(113.8e9, nu=0.342), 4430.0, 880e6),
        "carbon": Material(135e9, 5e9, 1600.0),
    }
)
"""Materials by name.

* steel: structural steel S355. E and ν of EN 1993-1-1, 3.2.6; yield strength of its table 3.1, up to 40 mm
  thick; density of EN 1991-1-1, table A.4.
* aluminium: EN AW-6082-T6. E, ν and density of EN 1999-1-1, 3.2.5; proof strength of its table 3.2b, extruded
  tube up to 5 mm thick.
* titanium: Ti-6Al-4V (grade 5), annealed. ASM data sheet MTP641.
* carbon: standard carbon fibre in epoxy, 60 % fibres, all along the bar (0°): E₁ and G₁₂ of Performance
  Composites, *Mechanical Properties of Carbon Fibre Composite Materials*. It does not yield. Layers at ±45°
  would make it stiffer in torsion and softer in bending: give E and G of the lay-up then.
"""
