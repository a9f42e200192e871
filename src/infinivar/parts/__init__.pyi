from . import amplifier, bearing, belt, gearhead, heat, linear, motor, screw, shaft_bearings, stage, tables
from .amplifier import Amplifier
from .battery import Battery
from .bearing import Bearing
from .belt import Belt, Rack, TimingBelt
from .gear_friction import GearFriction
from .gearhead import Gearhead
from .linear import Guideway, Pulley
from .linkage import Linkage
from .motor import Motor
from .rail import Rail
from .screw import Screw
from .shaft_bearings import CylinderBearings, PulleyBearings
from .spring import Spring, TorsionSpring
from .stage import Shaft
from .strain_wave import StrainWave
from .structure.stock import StockSpring, StockTube
from .structure.structure import Structure
from .tables.consistency import CatalogueCheck
from .tables.importing import PartImport
from .tables.search import PartSearch
from .tables.table import PartSet, PartTable

__all__ = [
    "Amplifier",
    "Battery",
    "Bearing",
    "Belt",
    "CatalogueCheck",
    "CylinderBearings",
    "GearFriction",
    "Gearhead",
    "Guideway",
    "Linkage",
    "Motor",
    "PartImport",
    "PartSearch",
    "PartSet",
    "PartTable",
    "Pulley",
    "PulleyBearings",
    "Rack",
    "Rail",
    "Screw",
    "Shaft",
    "Spring",
    "StockSpring",
    "StockTube",
    "StrainWave",
    "Structure",
    "TimingBelt",
    "TorsionSpring",
    "amplifier",
    "bearing",
    "belt",
    "gearhead",
    "heat",
    "linear",
    "motor",
    "screw",
    "shaft_bearings",
    "stage",
    "tables",
]
