# What the layering tests refuse outside this folder. The engine is a package of npm: no header, and no
# library to link.
set(engine_headers "Jolt/[A-Za-z0-9_/]*\\.h")
set(engine_types "JPH::")
set(engine_words "jolt-physics")
set(engine_folders "include/Jolt")
set(engine_libraries "libJolt")
set(engine_probes)
