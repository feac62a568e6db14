"""Writes crs_pyproj.csv: points of several reference systems as PROJ and its EPSG dataset have them.

    python3 survey/tests/crs_pyproj.py > survey/tests/crs_pyproj.csv

The transformation to WGS 84 is the published one that is named here, the one the software under test uses too: PROJ may
hold a better one, from a grid file or of a smaller area. What PROJ would prefer offline is stated in `preferred_m`.
"""

import math
import sys

import pyproj
from pyproj import CRS, Geod, Proj, Transformer, network
from pyproj.transformer import TransformerGroup

network.set_network_enabled(False)

# EPSG code, name of the published transformation ("" where there is none to do), points (place, latitude, longitude).
VIENNA = [("Vienna data", 48.1850, 16.3130), ("Vienna east", 48.20, 16.56), ("Eisenstadt", 47.85, 16.52), ("Graz", 47.07, 15.44)]
AUSTRIA = [("Austrian DEM data", 47.775, 15.40), ("Innsbruck", 47.27, 11.39), ("Bregenz", 47.50, 9.75), ("Linz", 48.30, 14.29)]
MINNESOTA = [("Minnesota data", 47.0178, -99.1600), ("Minneapolis", 44.98, -96.3), ("Austin", 30.27, -97.74)]
SYSTEMS = [
    (31256, "MGI to WGS 84 (3)", VIENNA),
    (31287, "MGI to WGS 84 (3)", AUSTRIA),
    (26914, "NAD83 to WGS 84 (1)", MINNESOTA),
    (32614, "", MINNESOTA),
    (32633, "", [("Vienna", 48.2, 16.37), ("Prague", 50.09, 14.42), ("near equator", 0.5, 17.9)]),
    (32756, "", [("Sydney", -33.87, 151.21), ("Hobart", -42.88, 147.33)]),
    (25833, "ETRS89 to WGS 84 (1)", [("Berlin", 52.52, 13.40), ("Oslo", 59.91, 10.75), ("Vienna", 48.2, 16.37)]),
    (4326, "", [("Jacksboro", 36.5, -84.3), ("Melbourne", -37.86, 144.77)]),
    (4258, "ETRS89 to WGS 84 (1)", [("Vienna", 48.2, 16.37), ("Lisbon", 38.72, -9.14)]),
    (27700, "OSGB36 to WGS 84 (6)", [("London", 51.5, -0.12), ("Inverness", 57.48, -4.22)]),
    (28992, "Amersfoort to WGS 84 (4)", [("Utrecht", 52.09, 5.12), ("Groningen", 53.22, 6.57)]),
    (2056, "CH1903+ to WGS 84 (1)", [("Zurich", 47.38, 8.54), ("Geneva", 46.2, 6.14)]),
    (31467, "DHDN to WGS 84 (2)", [("Hannover", 52.37, 9.73), ("Stuttgart", 48.78, 9.18)]),
]


def metres(d_lat, d_lon, lat):
    return math.hypot(d_lat, d_lon * math.cos(math.radians(lat))) * 111_320


def along_meridian(forward, lat, lon):
    """Convergence (rad, clockwise from true to grid north) and scale (grid over ground) on the WGS 84 meridian."""
    geod = Geod(ellps="WGS84")
    ends = [geod.fwd(lon, lat, azimuth, 100.0)[:2] for azimuth in (180.0, 0.0)]
    (x0, y0), (x1, y1) = (forward.transform(*end, direction="INVERSE") for end in ends)
    return -math.atan2(x1 - x0, y1 - y0), math.hypot(x1 - x0, y1 - y0) / 200.0


def main():
    print(f"# Written by survey/tests/crs_pyproj.py with pyproj {pyproj.__version__}, PROJ {pyproj.proj_version_str}; do not edit.")
    print("# x east, y north (degrees: longitude, latitude); lat, lon on WGS 84 in degrees. Transformation: the published one named.")
    print("# convergence_rad, point_scale: from the two ends of 200 m of WGS 84 meridian put through the same transformation.")
    print("# own_convergence_rad, own_scale: PROJ's factors, on the meridian and ellipsoid of the system's own datum.")
    print("# preferred_m: how far off PROJ would put the point by the transformation it prefers without grid files (m).")
    print(
        "epsg,place,lat_deg,lon_deg,x,y,convergence_rad,point_scale,own_convergence_rad,own_scale,preferred_m,transformation"
    )
    for epsg, name, points in SYSTEMS:
        crs = CRS.from_epsg(epsg)
        group = TransformerGroup(crs, "EPSG:4326", always_xy=True, allow_ballpark=False)
        forward = [t for t in group.transformers if name in t.description.split(" + ")] if name else [
            Transformer.from_crs(crs, "EPSG:4326", always_xy=True)
        ]
        if not forward:
            sys.exit(f"EPSG:{epsg}: no transformation {name} among {[t.description for t in group.transformers]}")
        proj = Proj(CRS.from_epsg(epsg)) if not crs.is_geographic else None
        for place, lat, lon in points:
            x, y = forward[0].transform(lon, lat, direction="INVERSE")
            lon_p, lat_p = Transformer.from_crs(crs, "EPSG:4326", always_xy=True).transform(x, y)
            factors = ["0.0", "", "0.0", ""]
            if proj is not None:
                own = proj.get_factors(*proj(x, y, inverse=True))
                factors = list(map(repr, along_meridian(forward[0], lat, lon)))
                factors += [repr(math.radians(own.meridian_convergence)), repr(own.meridional_scale)]
            far = metres(lat_p - lat, lon_p - lon, lat)
            print(f"{epsg},{place},{lat!r},{lon!r},{x!r},{y!r},{','.join(factors)},{far:.3f},{name}")


main()
