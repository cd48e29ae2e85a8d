#include "haptics/import/scan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>

#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/lower_case.h"
#include "engine/base/units.h"
#include "haptics/import/import.h"
#include "haptics/import/import_scan.h"

namespace typodont::haptics::importing {

std::size_t bytes_of(Element type) {
  constexpr std::size_t kBytes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return kBytes[static_cast<int>(type)];
}

template <class T>
static void decode_as(const std::vector<char>& bytes, bool swap, std::vector<float>& out) {
  constexpr std::size_t kPiece = 1 << 16;
  for_each_in_parallel((out.size() + kPiece - 1) / kPiece, [&](std::size_t piece) {
    for (std::size_t i = piece * kPiece; i < std::min((piece + 1) * kPiece, out.size()); ++i) {
      char b[sizeof(T)];
      std::memcpy(b, &bytes[i * sizeof(T)], sizeof(T));
      if (swap) std::reverse(b, b + sizeof(T));
      out[i] = static_cast<float>(std::bit_cast<T>(b));
    }
  });
}

std::vector<float> decode(const std::vector<char>& bytes, std::size_t count, Element type, bool swap) {
  std::vector<float> out(count);
  using Decode = void (*)(const std::vector<char>&, bool, std::vector<float>&);
  constexpr Decode kDecode[] = {decode_as<std::int8_t>,   decode_as<std::uint8_t>,  decode_as<std::int16_t>,
                                decode_as<std::uint16_t>, decode_as<std::int32_t>,  decode_as<std::uint32_t>,
                                decode_as<std::int64_t>,  decode_as<std::uint64_t>, decode_as<float>,
                                decode_as<double>};  // in the order of Element
  kDecode[static_cast<int>(type)](bytes, swap, out);
  return out;
}

void check_sizes(const std::filesystem::path& file, std::string_view place, const std::vector<long long>& sizes,
                 const std::optional<double>& memory) {
  double product = 1;
  std::string text;
  for (const long long n : sizes) {
    product *= static_cast<double>(n);
    text += fmt::format("{}{}", text.empty() ? "" : " x ", n);
  }
  if (sizes.size() != 3) {
    throw Error(file.string(), place, fmt::format("{} axes longer than one ({})", sizes.size(), text),
                "a scan of 3 axes");
  }
  for (const long long n : sizes) {
    if (n < 4) throw Error(file.string(), place, text, "at least 4 voxels along each axis");
  }
  if (product > kMaxVoxels) {
    throw Error(file.string(), place, fmt::format("{} = {:.3g} voxels", text, product),
                fmt::format("at most {:.3g} voxels", kMaxVoxels));
  }
  // Memory per voxel, bytes: two copies of the scan (one of them with exchanged axes) with 4 bytes per voxel.
  constexpr double kBytesPerVoxel = 8;
  if (const double most = memory.value_or(free_memory()); product * kBytesPerVoxel > most) {
    throw Error(file.string(), place,
                fmt::format("{} voxels, {:.0f} MB as they are read", text, product * kBytesPerVoxel * 1e-6),
                fmt::format("a scan that fits into {:.0f} MB, which are {}", most * 1e-6,
                            memory ? "the limit of --memory-mb" : "free"));
  }
}

void replace_impossible_steps(RawScan& scan) {
  for (int k = 0; k < 3; ++k) {
    glm::dvec3& step = scan.step[static_cast<std::size_t>(k)];
    if (const double length = glm::length(step); !std::isfinite(length) || length == 0) {
      scan.has_spacing = false;
      step = glm::dvec3(0);
      step[k] = 1;
    }
    if (!std::isfinite(scan.origin[k])) scan.origin[k] = 0;
  }
}

std::uintmax_t size_of_file(const std::filesystem::path& file) {
  return require_input(file, is_mesh_file(file) ? InputKind::kMesh : InputKind::kScan);
}

std::optional<std::vector<double>> parse_numbers(std::string_view text) {
  std::vector<double> numbers;
  const char* p = text.data();
  const char* end = p + text.size();
  while (true) {
    while (p < end && (std::isspace(static_cast<unsigned char>(*p)) || *p == ',')) ++p;
    if (p == end) return numbers;
    double value = 0;
    const auto [next, error] = std::from_chars(p, end, value);
    if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
    numbers.push_back(value);
    p = next;
  }
}

std::optional<double> millimetres_per(std::string unit) {
  std::erase(unit, ' ');
  if (unit == "mm" || unit == "millimeter" || unit == "millimetre" || unit == "millimeters" || unit == "millimetres")
    return 1;
  if (unit == "um" || unit == "\xc2\xb5m" || unit == "\xce\xbcm" || unit == "micron" || unit == "microns" ||
      unit == "micrometer" || unit == "micrometre" || unit == "micrometers" || unit == "micrometres") {
    return 1e-3;
  }
  if (unit == "cm" || unit == "centimeter" || unit == "centimetre") return 10;
  if (unit == "inch") return 25.4;
  if (unit == "foot") return 304.8;
  if (unit == "m" || unit == "meter" || unit == "metre" || unit == "meters" || unit == "metres") return 1e3;
  return std::nullopt;
}

std::string excerpt(std::string_view bytes) {
  std::string text = "\"";
  for (const char c : bytes.substr(0, 40)) text += std::isprint(static_cast<unsigned char>(c)) ? c : '.';
  return text + (bytes.size() > 40 ? "…\"" : "\"");
}

extern const ScanFormat nrrd_format, nifti_format, metaimage_format, dicom_format;

const std::vector<ScanFormat>& scan_formats() {
  static const std::vector<ScanFormat> formats{
      nrrd_format,
      nifti_format,
      metaimage_format,
#ifdef TYPODONT_DICOM
      dicom_format,
#endif
  };
  return formats;
}

/// Lists the formats: "NRRD .nrrd .nhdr, NIfTI .nii".
static std::string formats_in_words() {
  std::string text;
  for (const ScanFormat& format : scan_formats())
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", format.name, fmt::join(format.endings, " "));
  return text;
}

/// Recognises a format by the first bytes, otherwise by the extension; null: unknown.
static const ScanFormat* format_of(const std::filesystem::path& file, std::string_view start) {
  const std::string name = lower_case(file.filename().string());
  const auto ends = [&](const std::string& ending) { return name.ends_with(ending); };
  for (const ScanFormat& format : scan_formats()) {
    if ((format.begins && format.begins(start)) || std::any_of(format.endings.begin(), format.endings.end(), ends) ||
        std::any_of(format.further_extensions.begin(), format.further_extensions.end(), ends))
      return &format;
  }
  return nullptr;
}

int read_line(std::istream& in, std::string& line, std::size_t longest) {
  line.clear();
  int c = in.get();
  for (; c != EOF && c != '\n' && line.size() < longest; c = in.get()) line += static_cast<char>(c);
  return c;
}

std::string first_bytes(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string head(512, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  return head;
}

static RawScan read_any(const ScanRequest& request) {
  const std::filesystem::path& file = request.file;
  const std::string a_scan = fmt::format("a scan ({})", formats_in_words());
#ifdef TYPODONT_DICOM
  if (std::filesystem::is_directory(file)) return dicom_format.read(request);
#endif
  if (size_of_file(file) == 0) throw Error(file.string(), "", "an empty file", a_scan);
  const std::string start = first_bytes(file);
  if (start.empty()) throw Error(file.string(), "", "an unreadable file", a_scan);
#ifndef TYPODONT_DICOM
  if (start.size() >= 132 && start.substr(128, 4) == "DICM")
    throw Error(file.string(), "", "a DICOM file, which this build does not read (it was built without GDCM)", a_scan);
#endif
  if (const ScanFormat* format = format_of(file, start)) return format->read(request);
  throw Error(file.string(), "", fmt::format("a file that starts with {}", excerpt(start)),
              fmt::format("{} or a closed mesh ({})", a_scan, fmt::join(mesh_endings(), " ")));
}

// Exchanges and reverses axes, without mirroring the scan, so that they are nearest to the axes of the file's space.
// The rotation that remains is world_rotation.
static Scan align(RawScan&& raw) {
  Scan scan;
  scan.format = raw.format;
  scan.space = raw.space;
  scan.notes = std::move(raw.notes);
  scan.labels = std::move(raw.labels);
  glm::ivec3 from(0, 1, 2);  // from[w]: axis of the file that becomes axis w of the aligned scan
  glm::ivec3 sign(1, 1, 1);
  bool used[3] = {};
  double straightest = 1;
  bool placed[3] = {};
  for (int round = 0; round < 3; ++round) {  // finds the best pair of axes in each round
    double best = -1;
    int best_w = 0, best_f = 0;
    for (int w = 0; w < 3; ++w) {
      for (int f = 0; f < 3; ++f) {
        const double c =
            std::abs(raw.step[static_cast<std::size_t>(f)][w]) / glm::length(raw.step[static_cast<std::size_t>(f)]);
        if (!placed[w] && !used[f] && c > best) best = c, best_w = w, best_f = f;
      }
    }
    placed[best_w] = used[best_f] = true;
    from[best_w] = best_f;
    sign[best_w] = raw.step[static_cast<std::size_t>(best_f)][best_w] < 0 ? -1 : 1;
    straightest = std::min(straightest, best);
  }
  glm::ivec3 size;
  glm::dvec3 first = raw.origin;  // position of voxel (0,0,0) of the aligned scan
  for (int w = 0; w < 3; ++w) {
    const auto& step = raw.step[static_cast<std::size_t>(from[w])];
    size[w] = raw.size[from[w]];
    scan.spacing[w] = glm::length(step) * kMillimetre;
    if (sign[w] < 0) first += step * static_cast<double>(size[w] - 1);
  }
  constexpr double kOblique = 0.9999;  // cosine of 0.8°; a larger angle makes the scan oblique
  if (straightest < kOblique) {
    // Nearest rotation: repeated mean with the inverse transpose (Higham 1986).
    glm::dmat3 r;
    for (int w = 0; w < 3; ++w)
      r[w] = glm::normalize(raw.step[static_cast<std::size_t>(from[w])]) * static_cast<double>(sign[w]);
    for (int k = 0; k < 20; ++k) r = 0.5 * (r + glm::transpose(glm::inverse(r)));
    scan.world_rotation = r;
    scan.notes.push_back("the scan lies obliquely in its space: the volume keeps the scan's axes");
  }
  scan.origin = glm::transpose(scan.world_rotation) * first * kMillimetre;
  if (from != glm::ivec3(0, 1, 2) || sign != glm::ivec3(1, 1, 1)) {
    scan.notes.push_back(fmt::format("axes turned to those of the file's space: x from {}{}, y from {}{}, z from {}{}",
                                     sign.x < 0 ? "-" : "+", from.x, sign.y < 0 ? "-" : "+", from.y,
                                     sign.z < 0 ? "-" : "+", from.z));
  }
  scan.grey = Grid<float>(size);
  // Position of the first voxel in the file's data, and steps along each axis.
  const std::ptrdiff_t file_step[3] = {1, raw.size.x, static_cast<std::ptrdiff_t>(raw.size.x) * raw.size.y};
  std::ptrdiff_t first_voxel = 0, next[3];
  for (int a = 0; a < 3; ++a) {
    next[a] = sign[a] * file_step[from[a]];
    if (sign[a] < 0) first_voxel += (size[a] - 1) * file_step[from[a]];
  }
  // Processes slabs, which fit into the cache.
  constexpr int kSlab = 16;
  for_each_in_parallel((size.x + kSlab - 1) / kSlab, [&](int slab) {
    const int x_end = std::min((slab + 1) * kSlab, size.x);
    for (int y = 0; y < size.y; ++y) {
      for (int z = 0; z < size.z; ++z) {
        const float* row = raw.grey.data() + first_voxel + y * next[1] + z * next[2];
        for (int x = slab * kSlab; x < x_end; ++x) scan.grey(x, y, z) = row[x * next[0]];
      }
    }
  });
  return scan;
}

double undo_shear(const std::filesystem::path& file, RawScan& raw) {
  const glm::dvec3 u = glm::normalize(raw.step[0]), v = glm::normalize(raw.step[1]);
  glm::dvec3 n = glm::cross(u, v);
  if (glm::dot(n, raw.step[2]) < 0) n = -n;
  // Cosine of 89.4°; axes whose angle has a smaller cosine count as perpendicular.
  constexpr double kSquare = 0.01;
  if (std::abs(glm::dot(u, v)) > kSquare) {
    throw Error(file.string(), "axis directions",
                fmt::format("first axes at {:.4g} degrees", std::acos(glm::dot(u, v)) * 180 / kPi), "a right angle");
  }
  const double along = glm::dot(raw.step[2], n),
               angle = std::acos(std::clamp(along / glm::length(raw.step[2]), -1., 1.));
  constexpr double kStraight = 0.1 * kPi / 180;
  if (angle < kStraight) return 0;
  // Shift of each slice relative to the slice before, along both axes of a slice, voxels.
  const double shift[2] = {glm::dot(raw.step[2], u) / glm::length(raw.step[0]),
                           glm::dot(raw.step[2], v) / glm::length(raw.step[1])};
  const int last = raw.size.z - 1;
  int base[2], size[2];
  for (int a = 0; a < 2; ++a) {
    base[a] = static_cast<int>(std::floor(std::min(0.0, shift[a] * last)));
    size[a] = raw.size[a] + static_cast<int>(std::ceil(std::abs(shift[a] * last)));
  }
  check_sizes(file, "axis directions", {size[0], size[1], raw.size.z});
  float dark = raw.grey.empty() ? 0.0F : raw.grey[0];
  for (const float g : raw.grey) {
    if (g < dark) dark = g;
  }
  const auto nx = static_cast<std::size_t>(raw.size.x), ny = static_cast<std::size_t>(raw.size.y);
  const auto mx = static_cast<std::size_t>(size[0]), my = static_cast<std::size_t>(size[1]);
  std::vector<float> out(mx * my * static_cast<std::size_t>(raw.size.z), dark);
  // Cubic interpolation between four neighbours (Catmull-Rom).
  const auto cubic = [](float a, float b, float c, float d, float t) {
    return b + 0.5F * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
  };
  for_each_in_parallel(raw.size.z, [&](int k) {
    // new(i, j) = old(i + base[0] − shift[0]·k, j + base[1] − shift[1]·k): interpolates first along rows, then along
    // columns.
    const double fx = base[0] - shift[0] * k, fy = base[1] - shift[1] * k;
    const int ix = static_cast<int>(std::floor(fx)), iy = static_cast<int>(std::floor(fy));
    const float tx = static_cast<float>(fx - ix), ty = static_cast<float>(fy - iy);
    const float* slice = &raw.grey[static_cast<std::size_t>(k) * nx * ny];
    std::vector<float> rows(mx * ny, dark);
    const auto pick = [&](const float* line, int i, int count, std::size_t stride) {
      return i >= 0 && i < count ? line[static_cast<std::size_t>(i) * stride] : dark;
    };
    for (std::size_t j = 0; j < ny; ++j) {
      const float* line = slice + j * nx;
      for (int i = 0; i < size[0]; ++i) {
        const int at = i + ix;
        if (at < -1 || at >= raw.size.x) continue;
        const auto p = [&](int d) { return pick(line, at + d, raw.size.x, 1); };
        rows[j * mx + static_cast<std::size_t>(i)] = tx == 0 ? p(0) : cubic(p(-1), p(0), p(1), p(2), tx);
      }
    }
    float* to = &out[static_cast<std::size_t>(k) * mx * my];
    for (std::size_t i = 0; i < mx; ++i) {
      for (int j = 0; j < size[1]; ++j) {
        const int at = j + iy;
        if (at < -1 || at >= raw.size.y) continue;
        const auto p = [&](int d) { return pick(&rows[i], at + d, raw.size.y, mx); };
        to[static_cast<std::size_t>(j) * mx + i] = ty == 0 ? p(0) : cubic(p(-1), p(0), p(1), p(2), ty);
      }
    }
  });
  raw.origin += static_cast<double>(base[0]) * raw.step[0] + static_cast<double>(base[1]) * raw.step[1];
  raw.step[2] = along * n;
  raw.size.x = size[0], raw.size.y = size[1];
  raw.grey = std::move(out);
  return angle;
}

// Replaces NaN voxels by `nan_grey`. If it is empty, throws Error for a scan with NaN voxels.
static void replace_nan(const std::filesystem::path& file, RawScan& raw, const std::optional<double>& nan_grey) {
  std::size_t count = 0, first = 0;
  for (std::size_t i = raw.grey.size(); i-- > 0;) {
    if (!std::isfinite(raw.grey[i])) ++count, first = i;
  }
  if (count == 0) return;
  if (!nan_grey) {
    const auto nx = static_cast<std::size_t>(raw.size.x), ny = static_cast<std::size_t>(raw.size.y);
    throw Error(file.string(), fmt::format("voxel ({}, {}, {})", first % nx, first / nx % ny, first / (nx * ny)),
                fmt::format("{}, as in {} of {} voxels", raw.grey[first], count, raw.grey.size()),
                "a finite grey value; --nan-as GREY puts one in their place, e.g. that of air");
  }
  for (float& g : raw.grey) {
    if (!std::isfinite(g)) g = static_cast<float>(*nan_grey);
  }
  raw.notes.push_back(
      fmt::format("{} of {} voxels were no number and are taken as {:g}", count, raw.grey.size(), *nan_grey));
}

Scan read_scan(const ScanRequest& request, const std::optional<glm::dvec3>& spacing,
               const std::optional<double>& nan_grey, const SpacingLimits& limits) {
  const std::filesystem::path& file = request.file;
  RawScan raw = read_any(request);
  replace_nan(file, raw, nan_grey);
  constexpr std::string_view kAsk = "; give the true voxel with --spacing-mm X,Y,Z";
  if (spacing) {
    for (int a = 0; a < 3; ++a) {
      auto& step = raw.step[static_cast<std::size_t>(a)];
      const double length = glm::length(step);
      glm::dvec3 along(0);
      along[a] = 1;
      if (length > 0 && std::isfinite(length)) along = step / length;
      step = along * ((*spacing)[a] / kMillimetre);
    }
  } else if (!raw.has_spacing) {
    throw Error(file.string(), raw.spacing_place, "no voxel spacing", fmt::format("one in millimetres{}", kAsk));
  }
  const glm::dvec3 length(glm::length(raw.step[0]), glm::length(raw.step[1]), glm::length(raw.step[2]));
  const glm::dvec3 extent = length * glm::dvec3(raw.size);
  const std::string found = fmt::format("{:.6g} {:.6g} {:.6g}", length.x, length.y, length.z);
  if (!spacing && !raw.has_unit && length == glm::dvec3(1)) {
    throw Error(file.string(), raw.spacing_place,
                fmt::format("{} without a unit (in mm the scan would be {:.0f} x {:.0f} x {:.0f} mm)", found, extent.x,
                            extent.y, extent.z),
                fmt::format("the voxel in millimetres{}", kAsk));
  }
  for (int a = 0; a < 3; ++a) {
    if (length[a] * kMillimetre >= limits.smallest && length[a] * kMillimetre <= limits.largest) continue;
    // If the file states the unit, voxels that seem too large are probably real; so the message asks for a finer scan.
    const bool coarse = !spacing && raw.has_unit && length[a] * kMillimetre > limits.largest;
    throw Error(
        file.string(), spacing ? "--spacing-mm" : raw.spacing_place,
        fmt::format("{} mm (the scan would be {:.4g} x {:.4g} x {:.4g} mm)", found, extent.x, extent.y, extent.z),
        coarse ? fmt::format("a scan fine enough for {}: voxels of at most {:.3g} mm{}; where the file is wrong, "
                             "--spacing-mm X,Y,Z",
                             limits.of, limits.largest / kMillimetre, limits.instead)
               : fmt::format("voxels of {:.3g} to {:.3g} mm{}", limits.smallest / kMillimetre,
                             limits.largest / kMillimetre, spacing ? "" : kAsk));
  }
  // If the three axes lie in a plane, they define no orientation.
  const double volume = glm::dot(raw.step[0], glm::cross(raw.step[1], raw.step[2]));
  if (!(std::abs(volume) > 0.5 * length.x * length.y * length.z)) {
    throw Error(file.string(), "axis directions", "axes that are far from perpendicular", "a rectangular grid");
  }
  const bool labels = raw.labels.has_value();
  if (const double angle = undo_shear(file, raw); angle > 0) {
    if (labels) throw Error(file.string(), "axis directions", "a label map in slanted slices", "perpendicular axes");
    raw.notes.push_back(
        fmt::format("the slices were stacked at {:.1f} degrees to their normal; that was undone", angle * 180 / kPi));
  }
  return align(std::move(raw));
}

}  // namespace typodont::haptics::importing

namespace typodont::haptics {

bool is_dicom(const std::filesystem::path& file) {
  std::error_code code;
  if (std::filesystem::is_directory(file, code)) return true;
  const importing::ScanFormat* format = importing::format_of(file, importing::first_bytes(file));
  return format && format->name == std::string_view("DICOM");
}

}  // namespace typodont::haptics
