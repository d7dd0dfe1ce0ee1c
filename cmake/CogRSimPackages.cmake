# Debian packages: `scripts/package`, or `cpack -G DEB` in a build folder after its target product; they need Debian's
# dpkg-dev and file. A component of an install rule is the package of that name.
#
# The rule of the library's name: its SONAME is libcogrsim.so.0 until 1.0, and packages depend on the very version
# they were built with, because until then a minor version may change interfaces. From 1.0 on the number changes
# with each change of the ABI.
set(COGRSIM_PACKAGE_CONTACT "The CogRSim authors <authors@cogrsim.example.org>" CACHE STRING
    "Maintainer of the Debian packages")
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME cogrsim)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # it would go before that of each package
set(CPACK_PACKAGE_CONTACT ${COGRSIM_PACKAGE_CONTACT})
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE
  GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
# Our own libraries are found in the build tree; what depends on them says so below.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/lib)
set(CPACK_COMPONENTS_ALL "")
set(this "(= ${PROJECT_VERSION})")

# What every package has, and dpkg packs for every package of Debian.
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
configure_file(${CMAKE_CURRENT_LIST_DIR}/debian/changelog.in ${PROJECT_BINARY_DIR}/debian/changelog @ONLY)
execute_process(COMMAND gzip -9fn ${PROJECT_BINARY_DIR}/debian/changelog COMMAND_ERROR_IS_FATAL ANY)

# cogrsim_package(NAME SUMMARY TEXT [ALL] [SECTION s] [DEPENDS d…] [RECOMMENDS r…] [SUGGESTS s…]): the packages of
# all machines (ALL) have nothing compiled in them.
function(cogrsim_package name summary text)
  cmake_parse_arguments(arg "ALL" "SECTION" "DEPENDS;RECOMMENDS;SUGGESTS" ${ARGN})
  string(TOUPPER ${name} component)
  set(prefix CPACK_DEBIAN_${component})
  list(APPEND CPACK_COMPONENTS_ALL ${name})
  set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} PARENT_SCOPE)
  set(CPACK_COMPONENT_${component}_DESCRIPTION "${summary}\n${text}" PARENT_SCOPE)
  set(${prefix}_PACKAGE_NAME ${name} PARENT_SCOPE)
  if(NOT arg_SECTION)
    set(arg_SECTION science)
  endif()
  set(${prefix}_PACKAGE_SECTION ${arg_SECTION} PARENT_SCOPE)
  foreach(kind DEPENDS RECOMMENDS SUGGESTS)
    list(JOIN arg_${kind} ", " list)
    set(${prefix}_PACKAGE_${kind} "${list}" PARENT_SCOPE)
  endforeach()
  if(arg_ALL)
    set(${prefix}_PACKAGE_ARCHITECTURE all PARENT_SCOPE)
  else()
    set(${prefix}_PACKAGE_SHLIBDEPS ON PARENT_SCOPE)
  endif()
  set(doc ${CMAKE_INSTALL_DATADIR}/doc/${name})
  install(FILES ${PROJECT_SOURCE_DIR}/cmake/debian/copyright ${PROJECT_BINARY_DIR}/debian/changelog.gz
    DESTINATION ${doc} COMPONENT ${name})
endfunction()

cogrsim_package(libcogrsim0 "${PROJECT_DESCRIPTION}, libraries"
  "The simulation, scenes, sensors, recordings, and the compiler of scenes." SECTION libs)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY "=")
set(CPACK_DEBIAN_LIBCOGRSIM0_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/cmake/debian/triggers)
# What find_package(CogRSim) looks for.
cogrsim_package(libcogrsim-dev "${PROJECT_DESCRIPTION}, development files"
  "Headers, files for CMake and pkg-config, and the conformance suite for
engines. Controllers, supervisors, sensors and engines are plugins built
with it."
  SECTION libdevel DEPENDS "libcogrsim0 ${this}" "libeigen3-dev (>= 3.4)" libexpected-dev
  RECOMMENDS "cogrsim ${this}" cmake g++)
cogrsim_package(cogrsim "${PROJECT_DESCRIPTION}"
  "The program: scenes are run, tested, compared on several engines, swept,
drawn and recorded. It comes with an engine of its own, controllers, and a
library of robots."
  DEPENDS "libcogrsim0 ${this}"
  RECOMMENDS "cogrsim-backend-bullet ${this}" "cogrsim-renderer-osmesa ${this}"
  SUGGESTS cogrsim-studio cogrsim-examples cogrsim-doc gnuplot-nox ffmpeg)
if(TARGET cogrsim_studio)
  cogrsim_package(cogrsim-studio "${PROJECT_DESCRIPTION}, the studio"
    "Scenes are seen, edited and steered in the browser; a run becomes one page
that plays without a server."
    DEPENDS "cogrsim ${this}" RECOMMENDS "cogrsim-examples ${this}")
endif()
if(TARGET cogrsim_mpi)
  cogrsim_package(cogrsim-mpi "${PROJECT_DESCRIPTION}, sweeps by MPI"
    "Sweeps of parameters over the processes that mpirun starts, on several
machines."
    DEPENDS "cogrsim ${this}" RECOMMENDS openmpi-bin)
endif()
if("library" IN_LIST COGRSIM_PARTS)
  cogrsim_package(cogrsim-examples "${PROJECT_DESCRIPTION}, examples"
    "Scenes, controllers and experiments, which the studio offers copies of." ALL SUGGESTS cogrsim)
endif()

get_property(parts GLOBAL PROPERTY COGRSIM_PARTS_OF_THEIR_OWN)
list(REMOVE_DUPLICATES parts)
foreach(part IN LISTS parts)
  string(REGEX REPLACE ".*-" "" name ${part})
  if(part MATCHES "renderer")
    cogrsim_package(${part} "${PROJECT_DESCRIPTION}, pictures by ${name}"
      "Pictures of cameras, films and views, drawn without a screen." DEPENDS "cogrsim ${this}")
  elseif(TARGET ${name}_adapter)
    cogrsim_package(${part} "${PROJECT_DESCRIPTION}, engine ${name}"
      "The engine ${name} in a process of its own, as npm has it." ALL DEPENDS "cogrsim ${this}" "nodejs (>= 18)")
  elseif(TARGET ${name})
    cogrsim_package(${part} "${PROJECT_DESCRIPTION}, engine ${name}"
      "The engine ${name}, unmodified, as a backend of CogRSim." DEPENDS "cogrsim ${this}")
  endif()
endforeach()

# Made by scripts/site.
install(DIRECTORY ${PROJECT_BINARY_DIR}/site/ DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/cogrsim-doc/html
  COMPONENT cogrsim-doc OPTIONAL)
cogrsim_package(cogrsim-doc "${PROJECT_DESCRIPTION}, documentation"
  "Guides, lessons and references as pages, from
/usr/share/doc/cogrsim-doc/html/index.html on." ALL SECTION doc)

if(TARGET cogrsim_python)
  get_property(python_version GLOBAL PROPERTY COGRSIM_PYTHON_VERSION)
  string(REGEX MATCH "^([0-9]+)[.]([0-9]+)$" found "${python_version}")
  math(EXPR next "${CMAKE_MATCH_2} + 1")
  # Libraries and module are of one build; a module is of one version of Python.
  cogrsim_package(python3-cogrsim "${PROJECT_DESCRIPTION}, module for Python"
    "Scenes, simulations, frames as arrays of numpy, controllers in Python, many
worlds at once for learning, recordings."
    SECTION python DEPENDS "cogrsim ${this}" "python3 (>= ${python_version})"
      "python3 (<< ${CMAKE_MATCH_1}.${next})" python3-numpy
    SUGGESTS python3-pandas python3-matplotlib)
  # Python compiles modules into __pycache__, which dpkg does not know.
  set(CPACK_DEBIAN_PYTHON3-COGRSIM_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/cmake/debian/postinst
    ${PROJECT_SOURCE_DIR}/cmake/debian/prerm)
  set(CPACK_DEBIAN_PYTHON3-COGRSIM_PACKAGE_CONTROL_STRICT_PERMISSION ON)
endif()
include(CPack)
