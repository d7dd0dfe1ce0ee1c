# What the layering tests refuse outside this folder. The engine is a package of npm: no header, and no
# library to link.
set(engine_headers "rapier[a-z0-9_/]*\\.h")
set(engine_types "RAPIER[^A-Za-z_]")
set(engine_words "dimforge|rapier3d")
set(engine_folders "include/rapier")
set(engine_libraries "librapier")
set(engine_probes)
