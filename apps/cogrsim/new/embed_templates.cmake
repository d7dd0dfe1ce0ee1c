# Writes the files below FOLDER, but for its README.md, into the C++ file OUTPUT: see new_templates.h. The
# libraries of adapters come from ADAPTER.
file(GLOB_RECURSE files RELATIVE "${FOLDER}" "${FOLDER}/*")
list(REMOVE_ITEM files README.md)
list(SORT files)
list(APPEND files backend-js/cogrsim_backend.mjs backend-js/cogrsim_backend.d.mts backend-python/cogrsim_backend.py)
set(entries "")
foreach(file IN LISTS files)
  string(FIND "${file}" "/" slash)
  string(SUBSTRING "${file}" 0 ${slash} kind)
  math(EXPR slash "${slash} + 1")
  string(SUBSTRING "${file}" ${slash} -1 name)
  if(name MATCHES "^cogrsim_backend")
    file(READ "${ADAPTER}/${name}" text)
  else()
    file(READ "${FOLDER}/${file}" text)
  endif()
  if(text MATCHES "\\)template\"")
    message(FATAL_ERROR "${file} holds what ends its text in the program")
  endif()
  string(APPEND entries "    {\"${kind}\", \"${name}\", R\"template(${text})template\"},\n")
endforeach()
file(WRITE "${OUTPUT}" "// Made by the build from apps/cogrsim/templates.
#include \"new/new_templates.h\"

namespace cogrsim::cli {

const std::vector<TemplateFile>& template_files() {
  static const std::vector<TemplateFile> files = {
${entries}  };
  return files;
}

}  // namespace cogrsim::cli
")
