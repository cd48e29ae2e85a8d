#include <fmt/format.h>
#include <teem/nrrd.h>

#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <memory>

#include "engine/base/error.h"
#include "engine/base/late_library.h"
#include "engine/contract/tissue.h"
#include "haptics/import/scan.h"

namespace typodont::haptics::importing {

namespace {
constinit LateLibrary teem{TYPODONT_LATE_TEEM};
TYPODONT_LATE(teem, biffGetDone, nrrdBiffKey, nrrdElementNumber, nrrdElementSize, nrrdEncodingAscii, nrrdFLookup,
              nrrdFormatNRRD, nrrdIoStateNew, nrrdIoStateNix, nrrdKeyValueIndex, nrrdKeyValueSize, nrrdLoad, nrrdNew,
              nrrdNuke)

struct NukeNrrd {
  void operator()(Nrrd* n) const { nrrdNuke(n); }
};
struct NixState {
  void operator()(NrrdIoState* s) const { nrrdIoStateNix(s); }
};
using NrrdOwner = std::unique_ptr<Nrrd, NukeNrrd>;
using StateOwner = std::unique_ptr<NrrdIoState, NixState>;
}  // namespace

// Position for messages: "line 4 (type)", or "header".
static std::string place_of(const std::filesystem::path& file, const std::string& field) {
  std::ifstream in(file, std::ios::binary);
  std::string line;
  for (int number = 1; number < 1000 && std::getline(in, line) && !line.empty(); ++number) {
    if (line.starts_with(field + ":")) return fmt::format("line {} ({})", number, field);
  }
  return "header";
}

// Checks the length of lines, because teem 1.12 overflows a buffer on long lines of a damaged header.
static void check_header(const std::filesystem::path& file) {
  constexpr std::size_t kLongest = 700, kLongestText = 100000;
  std::ifstream in(file, std::ios::binary);
  std::string line;
  bool names = false;  // true after "data file: LIST": names follow to the end
  for (int number = 1; number < 100000; ++number) {
    read_line(in, line, kLongestText + 1);
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (number == 1 && !line.starts_with("NRRD"))
      throw Error(file.string(), "line 1", excerpt(line), "NRRD0001 to NRRD0005");
    if (line.empty()) return;
    // A line "key:=value" may also contain ": ".
    const bool pair = line.find(":=") < line.find(": ");
    const bool text = line[0] == '#' || line.starts_with("content:") || pair;
    const bool field = number == 1 || names || text || line.find(": ") != std::string::npos;
    if (!field || line.size() > (text ? kLongestText : kLongest)) {
      throw Error(file.string(), fmt::format("line {}", number), excerpt(line),
                  fmt::format("\"field: value\" of at most {} characters, or an empty line before the data", kLongest));
    }
    names = names || line.find("file: LIST") != std::string::npos || line.find("file: SKIPLIST") != std::string::npos;
  }
}

// Checks the length of words, because teem 1.12 overflows its stack on long ones.
static void check_words(const std::filesystem::path& file, bool after_header) {
  constexpr std::size_t kLongest = 100;
  std::ifstream in(file, std::ios::binary);
  if (after_header) {
    for (std::string line; std::getline(in, line) && !line.empty() && line != "\r";) {
    }
  }
  std::size_t length = 0;
  for (int c = in.get(); c != EOF; c = in.get()) {
    length = std::isspace(c) ? 0 : length + 1;
    if (length > kLongest) {
      throw Error(file.string(), "data", fmt::format("a number of more than {} digits", kLongest),
                  "numbers as text, with spaces between them");
    }
  }
}

static std::string expected_in(const std::string& field) {
  if (field == "type") return "a scalar type such as \"unsigned short\" or \"float\"";
  if (field == "sizes") return "three sizes of a scan that fits into memory";
  if (field == "dimension") return "3";
  if (field == "encoding") return "raw, gzip, bzip2, ascii or hex";
  if (field == "endian") return "little or big";
  if (field == "data file") return "a data file beside the header";
  return "a well-formed NRRD header";
}

// Last message of teem, nearest to the cause. `all`: receives all messages.
static std::string last_cause(std::string* all = nullptr) {
  const std::unique_ptr<char, decltype(&std::free)> text(biffGetDone(NRRD), &std::free);
  std::string cause = text ? text.get() : "an unreadable file";
  if (all) *all = cause;
  while (!cause.empty() && cause.back() == '\n') cause.pop_back();
  cause = cause.substr(cause.rfind('\n') + 1);
  if (const auto colon = cause.find(": "); colon != std::string::npos) cause = cause.substr(colon + 2);
  return cause;
}

[[noreturn]] static void fail(const std::filesystem::path& file) {
  std::string all, field;
  const std::string cause = last_cause(&all);
  for (const char* name :
       {"type", "sizes", "dimension", "encoding", "endian", "spacings", "space", "data file", "space directions",
        "space origin", "space units", "units", "kinds", "byte skip", "line skip"}) {
    std::string function = std::string("Parse_") + name + ":";
    std::replace(function.begin(), function.end(), ' ', '_');
    if (all.find(function) != std::string::npos) field = name;
  }
  if (all.find("DataFileIterNext") != std::string::npos) field = "data file";
  throw Error(file.string(), field.empty() ? "NRRD" : place_of(file, field), cause, expected_in(field));
}

// Names of label values, written as "2:=dentin", or "Segment0_Name:=Dentin" with "Segment0_LabelValue:=2" (3D Slicer).
static std::optional<std::map<int, std::string>> labels_of(const std::filesystem::path& file, const Nrrd& nrrd) {
  constexpr std::string_view kName = "_Name", kLabel = "_LabelValue", kLayer = "_Layer", kSegment = "Segment";
  const auto number = [](std::string_view text) {
    int value = -1;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() ? value : -1;
  };
  std::map<int, std::string> labels;
  std::map<std::string, std::pair<int, std::string>> segments;
  for (unsigned i = 0; i < nrrdKeyValueSize(&nrrd); ++i) {
    char *raw_key = nullptr, *raw_value = nullptr;
    nrrdKeyValueIndex(&nrrd, &raw_key, &raw_value, i);
    const std::unique_ptr<char, decltype(&std::free)> own_key(raw_key, &std::free), own_value(raw_value, &std::free);
    const std::string key = raw_key ? raw_key : "", value = raw_value ? raw_value : "";
    if (const int label = number(key); label > 0 && tissue_named(value)) labels[label] = value;
    if (!key.starts_with(kSegment)) continue;
    const std::string segment = key.substr(0, key.find('_'));
    if (key.ends_with(kLabel)) segments[segment].first = number(value);
    if (key.ends_with(kName)) segments[segment].second = value;
    if (key.ends_with(kLayer) && value != "0")
      throw Error(file.string(), key, value, "segments in one layer: where several overlap, a voxel has no one tissue");
  }
  for (const auto& [segment, named] : segments) {
    if (const auto& [label, name] = named; label > 0) labels[label] = name;
  }
  return labels.empty() ? std::nullopt : std::optional(labels);
}

static RawScan read_nrrd(const ScanRequest& request) {
  const std::filesystem::path& file = request.file;
  check_header(file);
  // Reads the header first, so that sizes are checked before memory is allocated.
  const NrrdOwner header(nrrdNew());
  const StateOwner state(nrrdIoStateNew());
  state->skipData = 1;
  if (nrrdLoad(header.get(), file.c_str(), state.get())) fail(file);
  if (state->format != nrrdFormatNRRD) throw Error(file.string(), "line 1", "no NRRD", "NRRD0001 to NRRD0005");
  if (header->type == nrrdTypeBlock) {
    throw Error(file.string(), place_of(file, "type"), "block", expected_in("type"));
  }
  std::vector<unsigned> axes;
  std::vector<long long> sizes;
  for (unsigned a = 0; a < header->dim; ++a) {
    if (header->axis[a].size == 1 && header->dim > 3) continue;
    axes.push_back(a);
    sizes.push_back(static_cast<long long>(std::min<std::size_t>(header->axis[a].size, 1ULL << 60)));
  }
  check_sizes(file, place_of(file, "sizes"), sizes, request.memory);
  const std::size_t count = nrrdElementNumber(header.get());
  const double bytes = static_cast<double>(count) * static_cast<double>(nrrdElementSize(header.get()));

  // Checks whether the file contains enough data.
  double present = 0;
  std::string data = "data";
  bool known = true;
  if (state->dataFNFormat) {
    // For numbered data files, the size is not checked here: teem reports missing files.
    known = false;
  } else if (state->dataFNArr->len > 0) {
    for (unsigned i = 0; i < state->dataFNArr->len; ++i) {
      const std::filesystem::path part = file.parent_path() / state->dataFN[i];
      present += static_cast<double>(size_of_file(part));
      data = "data file " + part.string();
    }
  } else {
    present = static_cast<double>(size_of_file(file));
  }
  const std::string encoding = state->encoding == nrrdEncodingAscii ? "ascii" : state->encoding->name;
  double least = 0;  // smallest possible size, in bytes, of the encoded data
  if (encoding == "raw") least = bytes;
  if (encoding == "gzip") least = bytes / 1032;  // 1032 is the highest compression ratio of the method deflate
  if (encoding == "bzip2") least = bytes / 46e6;
  if (encoding == "ascii") least = 2.0 * static_cast<double>(count) - 1;
  if (encoding == "hex") least = 2 * bytes;
  if (encoding == "ascii") {
    for (unsigned i = 0; i < state->dataFNArr->len; ++i) check_words(file.parent_path() / state->dataFN[i], false);
    if (state->dataFNFormat) {
      throw Error(file.string(), place_of(file, "data file"), "numbered files of numbers as text",
                  "a data file, or numbered files of another encoding");
    }
    if (state->dataFNArr->len == 0) check_words(file, true);
  }
  if (known && present < least) {
    throw Error(file.string(), data, fmt::format("{:.0f} bytes", present),
                encoding == "raw"
                    ? fmt::format("{:.0f} bytes", bytes)
                    : fmt::format("at least {:.0f} bytes of {} for {} voxels", std::ceil(least), encoding, count));
  }

  const NrrdOwner nrrd(nrrdNew());
  if (nrrdLoad(nrrd.get(), file.c_str(), nullptr)) {
    // The header was read before, so the data must be wrong.
    throw Error(file.string(), data, last_cause(),
                fmt::format("{:.0f} bytes of voxels ({} x {} x {}), encoded as {}", bytes, sizes[0], sizes[1], sizes[2],
                            encoding));
  }
  RawScan scan;
  scan.format = "NRRD";
  scan.size = {static_cast<int>(sizes[0]), static_cast<int>(sizes[1]), static_cast<int>(sizes[2])};
  scan.grey.resize(count);
  const auto lookup = nrrdFLookup[nrrd->type];
  const std::size_t slice = count / static_cast<std::size_t>(scan.size.z);
  for_each_in_parallel(scan.size.z, [&](int z) {
    const std::size_t first = static_cast<std::size_t>(z) * slice;
    for (std::size_t i = first; i < first + slice; ++i) scan.grey[i] = lookup(nrrd->data, i);
  });

  scan.labels = labels_of(file, *nrrd);
  scan.has_spacing = true;
  scan.spacing_place = place_of(file, nrrd->spaceDim ? "space directions" : "spacings");
  if (scan.spacing_place == "header") scan.spacing_place = "spacings";
  // Left-handed spaces: reverses the first axis.
  const bool left_handed = nrrd->space == nrrdSpaceLeftAnteriorSuperior || nrrd->space == nrrdSpace3DLeftHanded;
  for (std::size_t k = 0; k < 3; ++k) {
    const NrrdAxisInfo& axis = nrrd->axis[axes[k]];
    glm::dvec3& step = scan.step[k];
    std::string unit = axis.units ? axis.units : "";
    if (nrrd->spaceDim == 3) {
      for (int w = 0; w < 3; ++w) step[w] = axis.spaceDirection[w];
      // Spacings without directions are along the axes of the space.
      if (!std::isfinite(glm::length(step)) && std::isfinite(axis.spacing)) {
        step = glm::dvec3(0);
        step[static_cast<int>(k)] = axis.spacing;
        scan.spacing_place = place_of(file, "spacings");
      }
      if (nrrd->spaceUnits[k]) unit = nrrd->spaceUnits[k];
      // In an anatomical space the unit is mm, unless another is stated.
      scan.has_unit = scan.has_unit || !unit.empty() || nrrd->space != nrrdSpaceUnknown;
    } else {
      step[static_cast<int>(k)] = axis.spacing;
      scan.has_unit = scan.has_unit || !unit.empty();
    }
    if (!unit.empty()) {
      const std::optional<double> factor = millimetres_per(unit);
      if (!factor)
        throw Error(file.string(), place_of(file, nrrd->spaceDim ? "space units" : "units"), excerpt(unit),
                    "a unit of length (mm, um, cm or m)");
      step *= *factor;
      if (nrrd->spaceDim == 3) scan.origin[static_cast<int>(k)] = nrrd->spaceOrigin[k] * *factor;
    } else if (nrrd->spaceDim == 3) {
      scan.origin[static_cast<int>(k)] = nrrd->spaceOrigin[k];
    }
  }
  replace_impossible_steps(scan);
  const bool lps = nrrd->space == nrrdSpaceLeftPosteriorSuperior, ras = nrrd->space == nrrdSpaceRightAnteriorSuperior;
  scan.space = lps ? "LPS" : ras || nrrd->space == nrrdSpaceLeftAnteriorSuperior ? "RAS" : "";
  if (left_handed) {
    for (auto& step : scan.step) step.x = -step.x;
    scan.origin.x = -scan.origin.x;
  }
  return scan;
}

extern const ScanFormat nrrd_format;
const ScanFormat nrrd_format{
    "NRRD", {".nrrd", ".nhdr"}, {}, [](std::string_view bytes) { return bytes.starts_with("NRRD"); }, read_nrrd};

}  // namespace typodont::haptics::importing
