# What the layering tests refuse outside this folder: regular expressions, and headers to try.
set(engine_headers "SimTK|[Ss]imbody|simmath")
set(engine_types "SimTK::")
set(engine_words "[Ss]imbody|SIMBODY")
set(engine_folders "simbody|simtk|Simbody")
set(engine_libraries "SimTK")
set(engine_probes Simbody.h SimTKsimbody.h SimTKcommon.h)
