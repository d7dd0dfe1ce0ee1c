# `./scripts/demo` builds the target `product`, and `cmake --install` must work after it: everything
# installed from the build tree is linked by that target.
#   cmake -DBINARY_DIR=... -DNINJA=... -P built_by_product.cmake
cmake_minimum_required(VERSION 3.23)
execute_process(COMMAND ${NINJA} -C ${BINARY_DIR} -t commands product OUTPUT_VARIABLE commands
  RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "ninja -t commands: ${status}")
endif()
set(installed 0)
file(GLOB_RECURSE scripts ${BINARY_DIR}/*cmake_install.cmake)
foreach(script ${scripts})
  file(READ ${script} text)
  string(REGEX MATCHALL "\"${BINARY_DIR}/(bin|lib)/[^\"]*\"" files "${text}")
  foreach(file ${files})
    string(REGEX REPLACE "\"${BINARY_DIR}/(.*)\"" "\\1" file "${file}")
    # Symbolic links to a library are made with it.
    string(REGEX REPLACE "\\.so[.0-9]*$" ".so" file "${file}")
    string(REGEX MATCH " -o ${file}[.0-9]* " found "${commands}")
    math(EXPR installed "${installed} + 1")
    # The folder of a backend in a process of its own is copied to.
    string(FIND "${commands}" "adapter.mjs ${BINARY_DIR}/${file}" copied)
    if(NOT found AND copied LESS 0)
      message(SEND_ERROR "${script} installs ${file}, which the target product does not build")
    endif()
  endforeach()
endforeach()
message("${installed} files are installed from the build tree")
if(installed LESS 20)
  message(SEND_ERROR "these are fewer than there must be: does the test search the right folder?")
endif()
