// Reads DICOM from a folder, ZIP, DICOMDIR or multi-frame file. GDCM parses the files in a separate process
// (dicom_reader.cpp); this file groups, sorts and checks slices. It reads no personal data, and messages contain no
// file names.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/lower_case.h"
#include "engine/base/temporary_folder.h"
#include "engine/base/units.h"
#include "haptics/import/dicom/dicom_process.h"
#include "haptics/import/dicom/zip.h"
#include "haptics/import/scan.h"

namespace typodont::haptics::importing {

namespace {

namespace fs = std::filesystem;
using glm::dvec3;

constexpr std::size_t kMaxFiles = 20000;
constexpr int kDeepest = 8;  // largest depth of nested folders that are searched
// A series with fewer slices counts as an overview image (localizer), not as a scan.
constexpr std::size_t kMinSlices = 4;

struct Slice {
  std::size_t file = 0, frame = 0;
  bool placed = false;
  dvec3 position{0};               // mm, position of the slice's first pixel in the patient
  std::optional<double> location;  // mm, position along the stack
  double slope = 1, intercept = 0;
  DicomFile of;
};

/// Slices of the same series, size and orientation.
struct Stack {
  DicomHeader head;  // header of the first file, with only the frame of the first slice
  std::vector<Slice> slices;
  std::string note;  // how the slices were placed, if the files state no positions; for the user
};

bool begins_dicom(std::string_view start) {
  return start.size() >= 132 && start.substr(128, 4) == "DICM";
}

/// Lists the files of a folder. Links are ignored, because a cycle of links would be endless.
std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::size_t seen = 0;
  std::error_code code;
  for (fs::recursive_directory_iterator it(folder, fs::directory_options::skip_permission_denied, code), end;
       !code && it != end; it.increment(code)) {
    if (it.depth() >= kDeepest) it.disable_recursion_pending();
    if (it->is_symlink(code) || !it->is_regular_file(code)) continue;
    if (++seen > kMaxFiles)
      throw Error(folder.string(), "", fmt::format("more than {} files", kMaxFiles), "the folder of one scan");
    if (begins_dicom(first_bytes(it->path()))) files.push_back(it->path());
  }
  if (code) throw Error(folder.string(), "", code.message(), "a folder that can be read");
  std::ranges::sort(files);
  return files;
}

/// File that a DICOMDIR names; nullopt if the name leads out of the folder.
std::optional<fs::path> referenced(const fs::path& folder, const std::string& name) {
  fs::path at = folder;
  for (const fs::path& part : fs::path(name)) {
    if (part == ".." || part == "." || part.has_root_path()) return std::nullopt;
    const std::string lower = lower_case(part.string());
    std::error_code code;
    // Discs may show names in lower case, and copies may have extensions.
    const fs::path tried[] = {part, lower, part.string() + ".dcm", lower + ".dcm"};
    const auto* const found = std::ranges::find_if(tried, [&](const fs::path& p) { return fs::exists(at / p, code); });
    at /= found == std::end(tried) ? part : *found;
    if (fs::is_symlink(at, code)) return std::nullopt;
  }
  std::error_code code;
  return fs::is_regular_file(at, code) ? std::optional(at) : std::nullopt;
}

bool same_geometry(const DicomFrame& a, const DicomFrame& b) {
  constexpr double kTurned = 1e-3, kStretched = 1e-3;
  if (a.has_orientation != b.has_orientation || a.has_spacing != b.has_spacing) return false;
  for (int k = 0; k < 6; ++k) {
    if (std::abs(a.orientation[k] - b.orientation[k]) > kTurned) return false;
  }
  for (int k = 0; k < 2; ++k) {
    if (std::abs(a.spacing[k] - b.spacing[k]) > kStretched * std::abs(a.spacing[k])) return false;
  }
  return true;
}

dvec3 vec(const double* p) {
  return {p[0], p[1], p[2]};
}

/// Directions in the patient: right and down in the slice, and its normal, away from the viewer.
struct Axes {
  dvec3 right{1, 0, 0}, down{0, 1, 0}, normal{0, 0, 1};
};
Axes axes_of(const Stack& stack) {
  Axes axes;
  const DicomFrame& f = stack.head.frames[0];
  const dvec3 r = vec(f.orientation), d = vec(f.orientation + 3);
  if (f.has_orientation && glm::length(r) > 0.5 && glm::length(d) > 0.5)
    axes = {glm::normalize(r), glm::normalize(d), dvec3(0)};
  axes.normal = glm::cross(axes.right, axes.down);
  return axes;
}

constexpr double kSamePlace = 1e-3;  // mm, closer slices have the same position

/// Places the slices by Slice Location, if their positions are missing or all equal.
void place_by_location(Stack& stack) {
  std::vector<Slice>& all = stack.slices;
  const bool located = std::ranges::all_of(all, [](const Slice& s) { return s.location.has_value(); });
  const bool unplaced = std::ranges::none_of(all, &Slice::placed);
  const auto spread = [&](const auto& value) {
    const auto [low, high] = std::ranges::minmax_element(all, {}, value);
    return value(*high) - value(*low);
  };
  const dvec3 normal = axes_of(stack).normal;
  if (!located || all.size() < 2 || spread([](const Slice& s) { return *s.location; }) < kSamePlace) return;
  const auto beside = [&](const Slice& s) { return glm::length(s.position - all[0].position) >= kSamePlace; };
  if (!unplaced && std::ranges::any_of(all, beside)) return;
  for (Slice& s : all) {
    s.position += normal * (*s.location - (unplaced ? 0 : glm::dot(s.position, normal)));
    s.placed = true;
  }
  stack.note =
      fmt::format("{}, so the slices are placed by Slice Location (0020,1041); left and right may be exchanged",
                  unplaced ? "the slices have no Image Position" : "all slices have the same Image Position");
}

/// Divides a stack into one stack per scan of the same region. Counts removed copies in `copies`.
std::vector<Stack> split(Stack stack, std::size_t& copies) {
  const dvec3 normal = axes_of(stack).normal;
  const auto along = [&](const Slice& s) { return glm::dot(s.position, normal); };
  std::set<std::pair<std::uint64_t, std::size_t>> known;
  copies += std::erase_if(stack.slices, [&](const Slice& s) { return !known.insert({s.of.instance, s.frame}).second; });
  place_by_location(stack);
  std::ranges::stable_sort(stack.slices, [&](const Slice& a, const Slice& b) {
    return a.placed && b.placed ? along(a) < along(b) : std::pair(a.of.order, a.frame) < std::pair(b.of.order, b.frame);
  });
  const auto twice = [&](const Stack& s) {
    return std::ranges::adjacent_find(s.slices, [&](const Slice& a, const Slice& b) {
             return a.placed && b.placed && along(b) - along(a) < kSamePlace;
           }) != s.slices.end();
  };
  if (!twice(stack)) return {std::move(stack)};
  // Uses the first attribute that distinguishes the scans.
  using Key = std::string (*)(const DicomFile&);
  for (const Key key : {Key{[](const DicomFile& f) { return fmt::format("acquisition {}", f.acquisition); }},
                        Key{[](const DicomFile& f) { return fmt::format("phase {}", f.phase); }},
                        Key{[](const DicomFile& f) { return fmt::format("kernel {}", f.kernel); }},
                        Key{[](const DicomFile& f) { return fmt::format("echo {}", f.echo); }}}) {
    std::map<std::string, Stack> parts;
    for (const Slice& s : stack.slices) {
      Stack& part = parts.try_emplace(key(s.of), Stack{stack.head, {}, stack.note}).first->second;
      part.slices.push_back(s);
      part.head.file = part.slices[0].of;
    }
    if (parts.size() < 2 || std::ranges::any_of(parts, [&](const auto& part) { return twice(part.second); })) continue;
    std::vector<Stack> found;
    for (auto& [name, part] : parts) found.push_back(std::move(part));
    return found;
  }
  return {std::move(stack)};
}

std::vector<Stack> stacks_of(const std::vector<DicomHeader>& headers, std::size_t& copies) {
  constexpr std::size_t kMaxStacks = 1000;
  std::vector<Stack> stacks;
  for (std::size_t f = 0; f < headers.size(); ++f) {
    const DicomHeader& h = headers[f];
    if (h.file.kind != DicomKind::kImage || h.frames.size() != h.file.frames) continue;
    for (std::size_t k = 0; k < h.frames.size(); ++k) {
      const DicomFrame& frame = h.frames[k];
      const auto found = std::ranges::find_if(stacks, [&](const Stack& s) {
        const DicomFile& a = s.head.file;
        return a.series == h.file.series && a.columns == h.file.columns && a.rows == h.file.rows &&
               a.derived_view == h.file.derived_view && same_geometry(s.head.frames[0], frame);
      });
      if (found == stacks.end() && stacks.size() == kMaxStacks) continue;
      Stack& stack = found == stacks.end() ? stacks.emplace_back() : *found;
      if (stack.slices.empty()) stack.head.file = h.file, stack.head.frames = {frame};
      stack.slices.push_back({f, k, frame.has_position != 0, vec(frame.position),
                              frame.has_location ? std::optional(frame.location) : std::nullopt, frame.slope,
                              frame.intercept, h.file});
    }
  }
  std::vector<Stack> all;
  for (Stack& stack : stacks) {
    for (Stack& part : split(std::move(stack), copies)) all.push_back(std::move(part));
  }
  std::ranges::stable_sort(all, std::greater(), [](const Stack& s) { return s.slices.size(); });
  return all;
}

std::string in_words(const Stack& s) {
  const DicomFrame& f = s.head.frames[0];
  const DicomFile& file = s.head.file;
  return fmt::format("{}, series {}{}{}, {} slices of {} x {}{}", file.modality[0] ? file.modality : "?",
                     file.series_number, file.kernel[0] ? fmt::format(", kernel {}", file.kernel) : "",
                     file.phase ? fmt::format(", phase {}", file.phase) : "", s.slices.size(), file.columns, file.rows,
                     f.has_spacing ? fmt::format(", {:.3g} mm a voxel", f.spacing[1]) : "");
}

const Stack& chosen(const std::vector<Stack>& stacks, const ScanRequest& request, std::vector<std::string>& notes) {
  const std::string name = request.file.string();
  const auto scans = static_cast<std::size_t>(
      std::ranges::count_if(stacks, [](const Stack& s) { return s.slices.size() >= kMinSlices; }));
  if (stacks.empty() || scans == 0) {
    throw Error(
        name, "",
        stacks.empty() ? "no DICOM images of grey values"
                       : fmt::format("at most {} slices of one series", stacks[0].slices.size()),
        fmt::format("a DICOM series of at least {} slices: its folder, a ZIP of it, a DICOMDIR or one file with "
                    "all slices",
                    kMinSlices));
  }
  std::string list;
  for (std::size_t k = 0; k < scans; ++k) list += fmt::format("{}{}: {}", k ? "; " : "", k + 1, in_words(stacks[k]));
  if (request.series) {
    const int n = *request.series;
    if (n >= 1 && static_cast<std::size_t>(n) <= scans) return stacks[static_cast<std::size_t>(n - 1)];
    throw Error(name, "--series", fmt::format("{}", n), fmt::format("one of {}", list));
  }
  if (scans > 1) throw Error(name, "", fmt::format("{} series", scans), fmt::format("one, by --series N of {}", list));
  notes.push_back(in_words(stacks[0]));
  return stacks[0];
}

/// Positions of the result's slices as indices into the stack; a fraction lies between two slices.
struct SliceLevels {
  std::vector<double> at;
  dvec3 step{0}, origin{0};  // mm, step between slices, and position of the first slice
};

/// Slices whose distances differ by at most 2 % are used as they are; slices at other distances are interpolated.
/// Throws Error if a gap exceeds 1.5 times the median, because slices are missing.
SliceLevels levels_of(const std::string& name, const Stack& stack, std::vector<std::string>& notes) {
  constexpr double kEven = 0.02, kMissing = 1.5;
  const std::vector<Slice>& s = stack.slices;
  const dvec3 normal = axes_of(stack).normal;
  std::vector<double> t, gaps;
  for (const Slice& slice : s) t.push_back(glm::dot(slice.position, normal));
  for (std::size_t k = 1; k < t.size(); ++k) gaps.push_back(t[k] - t[k - 1]);
  std::vector<double> sorted = gaps;
  std::ranges::sort(sorted);
  const double usual = sorted[sorted.size() / 2];
  if (!(sorted.front() > 0.05 * usual) || !(usual > 0)) {
    const auto at = static_cast<std::size_t>(std::ranges::min_element(gaps) - gaps.begin());
    throw Error(name, fmt::format("slices {} and {}", at + 1, at + 2),
                fmt::format("{:.3g} mm apart, where {:.3g} mm is usual", gaps[at], usual),
                "slices at places of their own: one phase or one acquisition of a series");
  }
  std::size_t missing = 0;
  for (const double g : gaps)
    missing += g > kMissing * usual ? static_cast<std::size_t>(std::lround(g / usual)) - 1 : 0;
  if (missing > 0) {
    const auto at = static_cast<std::size_t>(std::ranges::max_element(gaps) - gaps.begin());
    throw Error(name, fmt::format("slices {} and {} of {}", at + 1, at + 2, s.size()),
                fmt::format("{:.3g} mm apart, where {:.3g} mm is usual: {} slices are missing in all", gaps[at], usual,
                            missing),
                fmt::format("a whole series: no gap beyond {:g} times the usual", kMissing));
  }
  SliceLevels levels;
  levels.origin = s.front().position;
  const dvec3 whole = s.back().position - s.front().position;
  const auto last = static_cast<double>(s.size() - 1);
  double worst = 0, aside = 0;
  for (std::size_t k = 0; k < s.size(); ++k) {
    worst = std::max(worst, std::abs(t[k] - t[0] - (t.back() - t[0]) * static_cast<double>(k) / last));
    const double fraction = (t[k] - t[0]) / (t.back() - t[0]);
    aside = std::max(aside, glm::length(s[k].position - levels.origin - fraction * whole));
  }
  const double pixel = std::min(stack.head.frames[0].spacing[0], stack.head.frames[0].spacing[1]);
  if (aside > std::max(0.5 * pixel, 1e-3)) {
    throw Error(name, "positions of the slices", fmt::format("slices up to {:.3g} mm beside a straight line", aside),
                "slices stacked along a line, at most half a voxel beside it");
  }
  const bool even = sorted.back() - sorted.front() <= kEven * usual && worst <= 0.1 * usual;
  const std::size_t count = even ? s.size() : static_cast<std::size_t>(std::lround((t.back() - t[0]) / usual)) + 1;
  levels.step = whole / static_cast<double>(count - 1);
  std::size_t below = 0;
  for (std::size_t k = 0; k < count; ++k) {
    if (even) {
      levels.at.push_back(static_cast<double>(k));
      continue;
    }
    const double want = t[0] + (t.back() - t[0]) * static_cast<double>(k) / static_cast<double>(count - 1);
    while (below + 2 < t.size() && t[below + 1] <= want) ++below;
    levels.at.push_back(static_cast<double>(below) + std::clamp((want - t[below]) / gaps[below], 0.0, 1.0));
  }
  if (!even) {
    notes.push_back(fmt::format("uneven slices ({:.3g} to {:.3g} mm apart) interpolated to {} of {:.3g} mm",
                                sorted.front(), sorted.back(), count, glm::length(levels.step)));
  }
  return levels;
}

RawScan read_stack(const std::string& name, const std::vector<fs::path>& files, const std::vector<DicomHeader>& headers,
                   const Stack& stack, const std::optional<double>& memory) {
  RawScan scan;
  const DicomFile& file = stack.head.file;
  const DicomFrame& first = stack.head.frames[0];
  scan.format = "DICOM";
  scan.has_unit = true;
  scan.spacing_place = "Pixel Spacing (0028,0030)";
  check_sizes(name, "size", {file.columns, file.rows, static_cast<long long>(stack.slices.size())}, memory);

  // Computes the positions of the slices.
  const Axes axes = axes_of(stack);
  const bool placed =
      (first.has_orientation || !stack.note.empty()) && std::ranges::all_of(stack.slices, &Slice::placed);
  scan.has_spacing = first.has_spacing && first.spacing[0] > 0 && first.spacing[1] > 0;
  SliceLevels levels;
  if (placed) {
    levels = levels_of(name, stack, scan.notes);
    scan.space = "LPS";
    if (!stack.note.empty()) scan.notes.push_back(stack.note);
  } else {
    // The slices have no positions: they are placed in their order, at the distance that the file states.
    const auto same_order = [](const Slice& a, const Slice& b) {
      return a.of.order == b.of.order && a.frame == b.frame;
    };
    if (std::ranges::adjacent_find(stack.slices, same_order) != stack.slices.end()) {
      throw Error(name, "Instance Number (0020,0013)", "slices without an order, a position or a location",
                  "slices that say where they lie");
    }
    if (first.gap_is_thickness)
      scan.notes.emplace_back("the file states no distance between slices: it is taken to be their thickness");
    for (std::size_t k = 0; k < stack.slices.size(); ++k) levels.at.push_back(static_cast<double>(k));
    levels.step = axes.normal * (first.has_gap ? first.gap : 1.0);
    if (stack.slices[0].placed) levels.origin = stack.slices[0].position;
    scan.has_spacing = scan.has_spacing && first.has_gap;
    scan.notes.emplace_back(
        "the slices do not say where they lie: taken in their order; left and right may be exchanged");
  }
  scan.step[0] = axes.right * (scan.has_spacing ? first.spacing[1] : 1.0);
  scan.step[1] = axes.down * (scan.has_spacing ? first.spacing[0] : 1.0);
  scan.step[2] = levels.step;
  scan.origin = levels.origin;
  if (placed && std::abs(file.tilt) > 0.5) {
    const double lean =
        std::acos(std::clamp(glm::dot(glm::normalize(levels.step), axes.normal), -1.0, 1.0)) * 180 / kPi;
    // Largest difference between the computed tilt of the gantry and the tilt that the file states, degrees.
    constexpr double kAgree = 1;
    if (std::abs(lean - std::abs(file.tilt)) > kAgree) {
      scan.notes.push_back(
          fmt::format("the gantry's tilt is given as {:.1f} degrees, the positions of the slices say "
                      "{:.1f}: the positions count",
                      file.tilt, lean));
    }
  }

  // Reads the pixels of the slices, one file after another.
  std::vector<std::size_t> needed;
  for (const Slice& s : stack.slices) needed.push_back(s.file);
  std::ranges::sort(needed);
  needed.erase(std::unique(needed.begin(), needed.end()), needed.end());
  const std::size_t area = std::size_t{file.columns} * file.rows;
  std::vector<fs::path> paths;
  std::uint64_t largest = 0, total = 0;
  for (const std::size_t f : needed) {
    paths.push_back(files[f]);
    const std::uint64_t bytes = 8ull * area * headers[f].file.frames;
    largest = std::max(largest, bytes), total += bytes;
  }
  constexpr float kPadding = -std::numeric_limits<float>::infinity();  // marks padding until all slices are read
  std::vector<float> raw(area * stack.slices.size());
  std::size_t next = 0;
  bool lossy = false;
  read_dicom_pixels(name, paths, largest, total, [&](const DicomPixels& pixels, std::vector<char>& bytes) {
    const std::size_t f = needed[next++];
    const std::size_t frames = headers[f].file.frames;
    const auto element = static_cast<Element>(std::min<std::uint32_t>(pixels.element, 9));
    const std::size_t slice_bytes = area * bytes_of(element);
    if (bytes.size() != slice_bytes * frames) {
      throw Error(name, fmt::format("image {} of {}", next, needed.size()), fmt::format("{} bytes", bytes.size()),
                  fmt::format("{} for {} x {} x {}", slice_bytes * frames, file.columns, file.rows, frames));
    }
    lossy = lossy || pixels.lossy;
    for (std::size_t k = 0; k < stack.slices.size(); ++k) {
      const Slice& s = stack.slices[k];
      if (s.file != f) continue;
      const auto from = bytes.begin() + static_cast<std::ptrdiff_t>(s.frame * slice_bytes);
      const std::vector<char> own(from, from + static_cast<std::ptrdiff_t>(slice_bytes));
      std::vector<float> grey = decode(own, area, element, false);
      // MONOCHROME1: the smallest value is white.
      const double sign = pixels.inverted ? -1 : 1;
      for (std::size_t i = 0; i < area; ++i) {
        const double stored = static_cast<double>(grey[i]);
        const bool is_padding =
            pixels.has_padding && stored >= pixels.lowest_padding && stored <= pixels.highest_padding;
        raw[k * area + i] = is_padding ? kPadding : static_cast<float>(sign * (s.slope * stored + s.intercept));
      }
    }
  });
  if (const auto padded = std::ranges::count(raw, kPadding); padded > 0) {
    float darkest = std::numeric_limits<float>::infinity();
    for (const float g : raw) darkest = g > kPadding ? std::min(darkest, g) : darkest;
    std::ranges::replace(raw, kPadding, darkest);
    scan.notes.push_back(fmt::format("{:.0f} % of the voxels lie outside the measured region (padding): read as air",
                                     100.0 * static_cast<double>(padded) / static_cast<double>(raw.size())));
  }
  if (lossy) scan.notes.emplace_back("the slices were compressed with loss: fine detail may be missing");

  // An uneven stack is interpolated between two slices.
  scan.size = {static_cast<int>(file.columns), static_cast<int>(file.rows), static_cast<int>(levels.at.size())};
  if (std::ranges::all_of(levels.at, [](double a) { return a == std::floor(a); })) {
    scan.grey = std::move(raw);
    return scan;
  }
  scan.grey.resize(area * levels.at.size());
  for (std::size_t k = 0; k < levels.at.size(); ++k) {
    const auto below = std::min(static_cast<std::size_t>(levels.at[k]), stack.slices.size() - 2);
    const auto fraction = static_cast<float>(levels.at[k] - static_cast<double>(below));
    for (std::size_t i = 0; i < area; ++i)
      scan.grey[k * area + i] = (1 - fraction) * raw[below * area + i] + fraction * raw[(below + 1) * area + i];
  }
  return scan;
}

RawScan read_dicom(const ScanRequest& request) {
  const std::string name = request.file.string();
  std::vector<fs::path> files;
  std::optional<TemporaryFolder> unpacked;
  if (fs::is_directory(request.file)) {
    files = files_in(request.file);
  } else if (is_zip(first_bytes(request.file))) {
    unpacked.emplace();
    files = unzip(request.file, unpacked->path());
    std::erase_if(files, [](const fs::path& f) { return !begins_dicom(first_bytes(f)); });
  } else {
    files = {request.file};
  }
  std::vector<DicomHeader> headers = read_dicom_headers(files);
  if (files.size() == 1 && headers[0].file.kind == DicomKind::kDirectory) {
    std::vector<fs::path> named;
    for (const std::string& reference : headers[0].references) {
      if (named.size() == kMaxFiles) break;
      if (const auto file = referenced(request.file.parent_path(), reference)) named.push_back(*file);
    }
    if (named.empty()) {
      throw Error(name, "Referenced File ID (0004,1500)",
                  fmt::format("{} files named, none of them there", headers[0].references.size()),
                  "a DICOMDIR beside the files that it names");
    }
    files = std::move(named);
    headers = read_dicom_headers(files);
  }
  std::size_t unreadable = 0, color = 0, copies = 0;
  for (const DicomHeader& h : headers) {
    unreadable += h.file.kind == DicomKind::kUnreadable;
    color += h.file.kind == DicomKind::kColor;
  }
  if (files.size() == 1 && unreadable == 1) throw Error(name, "", "a damaged DICOM file", "a whole one");
  const std::vector<Stack> stacks = stacks_of(headers, copies);
  std::vector<std::string> notes;
  const auto refuse_malformed = [&](const std::optional<std::uint64_t>& series) {
    for (const DicomHeader& h : headers) {
      if (h.malformed.empty() || (series && h.file.series != *series)) continue;
      const std::size_t end = h.malformed.find('\n');
      throw Error(name, h.malformed.substr(0, end), excerpt(std::string_view(h.malformed).substr(end + 1)),
                  "numbers with a decimal point");
    }
  };
  if (stacks.empty()) refuse_malformed(std::nullopt);
  const Stack& stack = chosen(stacks, request, notes);
  refuse_malformed(stack.head.file.series);
  RawScan scan = read_stack(name, files, headers, stack, request.memory);
  if (unreadable > 0) notes.push_back(fmt::format("{} damaged DICOM files were left out", unreadable));
  if (color > 0) notes.push_back(fmt::format("{} colour pictures were left out", color));
  if (copies > 0) notes.push_back(fmt::format("{} second copies of slices were left out", copies));
  if (stacks.size() > 1 && !request.series)
    notes.push_back(fmt::format("{} overview pictures beside the series were left out", stacks.size() - 1));
  scan.notes.insert(scan.notes.begin(), notes.begin(), notes.end());
  return scan;
}

}  // namespace

extern const ScanFormat dicom_format;
const ScanFormat dicom_format{"DICOM",
                              {".dcm", ".zip"},
                              {".ima", "dicomdir"},
                              [](std::string_view bytes) { return begins_dicom(bytes) || is_zip(bytes); },
                              read_dicom};

}  // namespace typodont::haptics::importing
