# Debian packages: `cpack -G DEB` in the build folder, after `cmake --build . --target product`; it needs Debian's
# dpkg-dev and file. cogrsim has the program, the SDK, the engines and plugins, and the examples;
# python3-cogrsim has the Python module.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME cogrsim)
set(CPACK_PACKAGE_CONTACT "The CogRSim developers <cogrsim@localhost>")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
# Its own libraries are found in the build tree; they have no package yet.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/lib)
set(CPACK_COMPONENTS_ALL cogrsim)
set(CPACK_DEBIAN_COGRSIM_PACKAGE_NAME cogrsim)
# What find_package(CogRSim) looks for; dpkg-shlibdeps adds the shared libraries.
set(CPACK_DEBIAN_COGRSIM_PACKAGE_DEPENDS "libeigen3-dev (>= 3.4), libexpected-dev")
set(CPACK_DEBIAN_COGRSIM_PACKAGE_RECOMMENDS "gnuplot-nox, ffmpeg")
set(CPACK_COMPONENT_COGRSIM_DESCRIPTION "${PROJECT_DESCRIPTION}
 The program cogrsim, its physics engines and plugins, and the SDK for C++.")
if(TARGET cogrsim_python)
  get_property(python_version GLOBAL PROPERTY COGRSIM_PYTHON_VERSION)
  string(REGEX MATCH "^([0-9]+)[.]([0-9]+)$" found "${python_version}")
  math(EXPR next "${CMAKE_MATCH_2} + 1")
  list(APPEND CPACK_COMPONENTS_ALL python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-cogrsim)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  # Libraries and module are of one build; a module is of one version of Python.
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "cogrsim (= ${PROJECT_VERSION}), python3 (>= ${python_version}), \
python3 (<< ${CMAKE_MATCH_1}.${next}), python3-numpy")
  # Python compiles modules into __pycache__, which dpkg does not know.
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/cmake/debian/postinst
    ${PROJECT_SOURCE_DIR}/cmake/debian/prerm)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_STRICT_PERMISSION ON)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-pandas, python3-matplotlib")
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION "${PROJECT_DESCRIPTION}, module for Python
 Scenes, simulations, frames as arrays of numpy, controllers in Python, many worlds
 at once for learning, recordings.")
endif()
include(CPack)
