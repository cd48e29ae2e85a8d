# Writes the C++ file OUTPUT, which defines build_identity() (engine/base/build_identity.h). FOLDER: the root of the
# sources; LIST: a file with one source per line, relative to FOLDER; OPTIONS: compiler and compiler options.
file(STRINGS ${LIST} sources)
set(all "${OPTIONS}")
foreach(source ${sources})
  file(SHA256 ${FOLDER}/${source} hash)
  string(APPEND all "\n${source} ${hash}")
endforeach()
string(SHA256 hash "${all}")
string(SUBSTRING ${hash} 0 16 digits)
file(WRITE ${OUTPUT} "#include \"engine/base/build_identity.h\"

namespace typodont {

std::uint64_t build_identity() noexcept {
  return 0x${digits};
}

}  // namespace typodont
")
