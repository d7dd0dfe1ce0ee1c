# What the layering tests refuse outside this folder: regular expressions, and headers to try.
set(engine_headers "ode/[a-z_]+\\.h")
set(engine_types "d(WorldID|BodyID|GeomID|SpaceID|JointID|Contact|ContactGeom|JointGroupID|Real)[^A-Za-z_]")
set(engine_words "libode|ODE::")
set(engine_folders "include/ode")
set(engine_libraries "libode")
# Its headers lie on the compiler's own path: nothing can keep them out of reach, only the search for names.
set(engine_probes)
