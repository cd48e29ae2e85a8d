#include "haptics/import/volume_export.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>

#include "engine/base/error.h"
#include "engine/base/lower_case.h"
#include "engine/base/partial_file.h"
#include "engine/base/units.h"
#include "haptics/import/dicom/segmentation_file.h"

namespace typodont::haptics {

namespace {

/// Returns the labels in the order that all formats require: x is the fastest index.
std::string labels_of(const DenseTissue& t) {
  std::string labels;
  labels.reserve(t.tissue.size());
  for (int z = 0; z < t.size.z; ++z) {
    for (int y = 0; y < t.size.y; ++y) {
      for (int x = 0; x < t.size.x; ++x) {
        const std::size_t i = t.at(x, y, z);
        labels += t.distance[i] <= 0 ? static_cast<char>(t.tissue[i]) : '\0';
      }
    }
  }
  return labels;
}

/// Transformation from voxels to mm in the space LPS. The columns of `step` are the steps along x, y and z.
struct Placing {
  glm::dmat3 step{1};
  glm::dvec3 origin{0};
};
Placing placing_of(const DenseTissue& t) {
  Placing p{glm::mat3_cast(t.place.X_FW.R) * (t.frame.voxel / kMillimetre),
            t.place.X_FW * t.frame.origin / kMillimetre};
  // Removes the rounding errors of the quaternion, so that the steps of a volume along the axes contain exact zeros.
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      constexpr double kRounding = 1e-13;
      if (std::abs(p.step[column][row]) < kRounding) p.step[column][row] = 0;
    }
  }
  if (t.place.axes == PatientAxes::kRas) {
    const glm::dmat3 turned(glm::dvec3(-1, 0, 0), glm::dvec3(0, -1, 0), glm::dvec3(0, 0, 1));
    p = {turned * p.step, turned * p.origin};
  }
  return p;
}

std::string gzip(const std::string& bytes) {
  constexpr int kLevel = 6, kGzip = 15 + 16;
  z_stream z{};
  if (deflateInit2(&z, kLevel, Z_DEFLATED, kGzip, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw RunFailure("zlib does not start");
  std::string out;
  std::array<char, 1 << 16> piece;
  constexpr std::size_t kMaxAtOnce = 1u << 30;
  std::size_t done = 0;
  int state = Z_OK;
  while (state == Z_OK) {
    if (z.avail_in == 0 && done < bytes.size()) {
      const std::size_t n = std::min(kMaxAtOnce, bytes.size() - done);
      z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data() + done));
      z.avail_in = static_cast<uInt>(n);
      done += n;
    }
    z.next_out = reinterpret_cast<Bytef*>(piece.data());
    z.avail_out = static_cast<uInt>(piece.size());
    state = deflate(&z, done == bytes.size() ? Z_FINISH : Z_NO_FLUSH);
    out.append(piece.data(), piece.size() - z.avail_out);
  }
  deflateEnd(&z);
  return out;
}

// The samples of a volume, with x as the fastest index, and their type in the file.
struct Samples {
  std::string bytes;
  const char* nrrd_type;
  std::int16_t nifti_type, nifti_bits;
  std::string nrrd_lines;  // additional lines for the header of an NRRD file
};

Samples label_samples(const DenseTissue& t) {
  constexpr std::int16_t kUint8 = 2, kBits = 8;
  Samples samples{labels_of(t), "uint8", kUint8, kBits, ""};
  std::array<bool, kTissueCount> occurs{};
  for (const char label : samples.bytes) occurs[static_cast<std::size_t>(label)] = true;
  for (std::size_t k = 1; k < occurs.size(); ++k) {
    if (occurs[k]) samples.nrrd_lines += fmt::format("{}:={}\n", k, name_of(static_cast<Tissue>(k)));
  }
  return samples;
}

Samples distance_samples(const DenseTissue& t) {
  constexpr std::int16_t kFloat = 16, kBits = 32;
  static_assert(std::endian::native == std::endian::little, "samples are written in the machine's order");
  Samples samples{std::string(sizeof(float) * t.distance.size(), '\0'), "float", kFloat, kBits,
                  "endian: little\nTypodont:=signed distance to the surface in mm, negative inside\n"};
  char* to = samples.bytes.data();
  for (int z = 0; z < t.size.z; ++z) {
    for (int y = 0; y < t.size.y; ++y) {
      for (int x = 0; x < t.size.x; ++x, to += sizeof(float)) {
        const auto mm = static_cast<float>(static_cast<double>(t.distance[t.at(x, y, z)]) / kMillimetre);
        std::memcpy(to, &mm, sizeof mm);
      }
    }
  }
  return samples;
}

std::string nrrd_of(const DenseTissue& t, const Samples& samples) {
  const Placing p = placing_of(t);
  const auto vec = [](const glm::dvec3& v) { return fmt::format("({:.12g},{:.12g},{:.12g})", v.x, v.y, v.z); };
  return fmt::format(
             "NRRD0004\ntype: {}\ndimension: 3\nspace: left-posterior-superior\nsizes: {} {} {}\nspace directions: {} "
             "{} {}\nkinds: domain domain domain\nencoding: gzip\nspace origin: {}\n{}\n",
             samples.nrrd_type, t.size.x, t.size.y, t.size.z, vec(p.step[0]), vec(p.step[1]), vec(p.step[2]),
             vec(p.origin), samples.nrrd_lines) +
         gzip(samples.bytes);
}

std::string nifti_of(const DenseTissue& t, const Samples& samples) {
  const Placing p = placing_of(t);
  // Length of the header in bytes, including four bytes that state that no extension follows.
  constexpr std::size_t kHeader = 352;
  std::string head(kHeader, '\0');
  const auto put = [&](std::size_t at, auto value) { std::memcpy(&head[at], &value, sizeof value); };
  constexpr std::int16_t kScannerSpace = 1;
  constexpr char kMillimetres = 2;
  put(0, std::int32_t{348});
  put(40, std::int16_t{3});
  for (int a = 0; a < 3; ++a) {
    put(42 + 2 * static_cast<std::size_t>(a), static_cast<std::int16_t>(t.size[a]));
    put(80 + 4 * static_cast<std::size_t>(a), static_cast<float>(glm::length(p.step[a])));
  }
  for (std::size_t a = 3; a < 7; ++a) put(42 + 2 * a, std::int16_t{1});
  put(70, samples.nifti_type);
  put(72, samples.nifti_bits);
  put(76, 1.0F);  // pixdim[0] of the format: 1 means that the third axis is not reversed
  put(108, static_cast<float>(kHeader));
  put(112, 1.0F);  // factor by which a stored number is multiplied to get the value
  put(123, kMillimetres);
  put(254, kScannerSpace);
  for (int row = 0; row < 3; ++row) {
    const double sign = row < 2 ? -1 : 1;  // LPS to RAS: signs of x and y change
    for (int column = 0; column < 4; ++column) {
      const double value = column < 3 ? p.step[column][row] : p.origin[row];
      put(280 + 16 * static_cast<std::size_t>(row) + 4 * static_cast<std::size_t>(column),
          static_cast<float>(sign * value));
    }
  }
  if (samples.nifti_bits == 8) {
    constexpr std::int16_t kLabelIntent = 1002;
    put(68, kLabelIntent);
    std::ranges::copy(kTissueLabels, &head[328]);
  }
  std::memcpy(&head[344], "n+1", 4);
  return head + samples.bytes;
}

/// Writes a volume to a file. `dicom` makes the content of a DICOM file, or is empty.
void write(const DenseTissue& t, const std::filesystem::path& file, const Samples& samples, const char* what,
           const std::function<std::string()>& dicom) {
  const std::string ending = lower_case(file.extension().string());
  const bool nifti = ending == ".nii";
  constexpr int kMaxNifti = 32767;
  if (nifti && glm::any(glm::greaterThan(t.size, glm::ivec3(kMaxNifti)))) {
    throw Error(file.string(), "size", fmt::format("{} x {} x {} voxels", t.size.x, t.size.y, t.size.z),
                fmt::format("at most {} along an axis of a NIfTI file; a .nrrd file has no such limit", kMaxNifti));
  }
  if (ending == ".dcm" && !dicom)
    throw Error(file.string(), "extension", "\".dcm\"", ".nrrd or .nii: a DICOM segmentation contains only labels");
  PartialFile partial(file, FileKind::kLabels);
  const std::string bytes = nifti ? nifti_of(t, samples) : ending == ".dcm" ? dicom() : nrrd_of(t, samples);
  std::ofstream out(partial.path(), std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw Error(file.string(), "", std::strerror(errno), fmt::format("room for the {}", what));
  partial.keep();
}

}  // namespace

void write_labels(const DenseTissue& tissue, const std::filesystem::path& file) {
  const Samples samples = label_samples(tissue);
  write(tissue, file, samples, "labels", [&] {
    const Placing p = placing_of(tissue);
    return importing::dicom_segmentation(file.string(), tissue.size, samples.bytes, p.step, p.origin);
  });
}

void write_distances(const DenseTissue& tissue, const std::filesystem::path& file) {
  write(tissue, file, distance_samples(tissue), "distances", {});
}

}  // namespace typodont::haptics
