#!/usr/bin/env python3
"""Unit and direction of every vertical reference system of the EPSG dataset, from PROJ's database.

python3 vertical_epsg.py > vertical_epsg.csv, with pyproj 3.7.2 (PROJ 9.5.1, EPSG v11.022).
"""
import sqlite3
import pathlib

import pyproj

QUERY = """
SELECT v.code, u.conv_factor, a.orientation, v.name FROM vertical_crs v
JOIN axis a ON (a.coordinate_system_auth_name, a.coordinate_system_code)
             = (v.coordinate_system_auth_name, v.coordinate_system_code)
JOIN unit_of_measure u ON (u.auth_name, u.code) = (a.uom_auth_name, a.uom_code)
WHERE v.auth_name = 'EPSG' ORDER BY v.code
"""

database = sqlite3.connect(pathlib.Path(pyproj.datadir.get_data_dir()) / "proj.db")
version = dict(database.execute("SELECT key, value FROM metadata"))
print(f"# Made by vertical_epsg.py from PROJ {version['PROJ.VERSION']}, EPSG {version['EPSG.VERSION']}.")
print("code,unit_m,direction,name")
for row in database.execute(QUERY):
    print(*row, sep=",")
