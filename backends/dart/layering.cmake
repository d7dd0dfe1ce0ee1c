# What the layering tests refuse outside this folder: regular expressions, and headers to try.
set(engine_headers "dart/[a-z]+/[A-Za-z/]+\\.hpp|dart/(dart|config)\\.hpp")
set(engine_types "dart::(simulation|dynamics|constraint|collision|common|math)")
set(engine_words "libdart")
set(engine_folders "include/dart")
set(engine_libraries "libdart")
# Its headers lie on the compiler's own path: nothing can keep them out of reach, only the search for names.
set(engine_probes)
