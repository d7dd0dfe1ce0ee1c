# What the layering tests refuse outside this folder. The engine is a package of npm: no header, and no
# library to link.
set(engine_headers "Px[A-Za-z]+\\.h")
set(engine_types "physx::")
set(engine_words "physx-js-webidl")
set(engine_folders "include/physx")
set(engine_libraries "libPhysX")
set(engine_probes)
