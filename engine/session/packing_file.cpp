#include "engine/session/packing_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <string>

#include "engine/base/error.h"
#include "engine/base/fnv.h"
#include "engine/base/partial_file.h"
#include "engine/session/format/hdf5.h"
#include "engine/session/hash.h"

namespace typodont::session {

namespace {

constexpr const char* kPackingFormat = "typodont_packing";
constexpr std::uint64_t kVersion = 1;
// Largest number of spheres. More need over half a gigabyte, so the file is probably damaged.
constexpr hsize_t kMaxSpheres = 16'000'000;

std::string checksum_of(const SpherePacking& p) {
  Fnv1a hash;
  for (const dvec3& c : p.center) hash.add(c.x), hash.add(c.y), hash.add(c.z);
  for (const double r : p.radius) hash.add(r);
  for (const Tissue t : p.tissue) hash.add(static_cast<std::uint8_t>(t));
  for (const double v : p.solid_volume) hash.add(v);
  hash.add(p.seed), hash.add(p.tissue_hash), hash.add(p.max_radius), hash.add(p.max_hole);
  return to_text(hash);
}

bool write_array(hid_t file, const char* name, hid_t type, hsize_t rows, hsize_t columns, const void* data) {
  const hsize_t extent[2] = {rows, columns};
  H5 space(H5Screate_simple(columns > 1 ? 2 : 1, extent, nullptr), H5Sclose);
  const H5 properties = without_times(H5P_DATASET_CREATE);
  H5 dataset(H5Dcreate2(file, name, type, space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT), H5Dclose);
  return dataset && H5Dwrite(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0;
}

/// Reads a dataset. `rows`: required number of rows; 0: any number from 1. resize(rows) must return the memory for
/// them.
template <class Resize>
void read_array(hid_t file, const std::string& path, const char* name, H5T_class_t kind, hid_t type, hsize_t rows,
                hsize_t columns, Resize&& resize) {
  const auto refuse = [&](const std::string& found) {
    throw Error(path, fmt::format("dataset \"{}\"", name), found,
                fmt::format("{} x {} numbers", rows > 0 ? fmt::format("{}", rows) : "n", columns));
  };
  H5L_info_t link;
  if (H5Lexists(file, name, H5P_DEFAULT) <= 0 || H5Lget_info(file, name, &link, H5P_DEFAULT) < 0) refuse("nothing");
  if (link.type != H5L_TYPE_HARD) refuse("a link to other data");
  H5 dataset(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose);
  if (!dataset) refuse(h5_reason());
  // External data files and virtual datasets could read other files.
  H5 layout(H5Dget_create_plist(dataset.get()), H5Pclose);
  if (H5Pget_layout(layout.get()) != H5D_CONTIGUOUS || H5Pget_external_count(layout.get()) != 0) {
    refuse("data outside of the file");
  }
  H5 space(H5Dget_space(dataset.get()), H5Sclose);
  H5 stored(H5Dget_type(dataset.get()), H5Tclose);
  hsize_t extent[2] = {0, 1};
  const int dimensions = H5Sget_simple_extent_ndims(space.get());
  if (dimensions != (columns > 1 ? 2 : 1) || H5Sget_simple_extent_dims(space.get(), extent, nullptr) < 0 ||
      H5Tget_class(stored.get()) != kind || extent[1] != columns || extent[0] < 1 || extent[0] > kMaxSpheres ||
      (rows > 0 && extent[0] != rows)) {
    refuse(fmt::format("{} x {}", extent[0], extent[1]));
  }
  // Compares the size that the file states with the size of its stored data before allocating memory.
  if (H5Dget_storage_size(dataset.get()) < extent[0] * columns * H5Tget_size(stored.get())) refuse("fewer numbers");
  void* to = resize(static_cast<std::size_t>(extent[0]));
  if (H5Dread(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, to) < 0) refuse(h5_reason());
}

bool is_packing(const std::filesystem::path& file) {
  const H5 h5(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  std::string format;
  return h5 && get_attribute(h5.get(), "format", format) && format == kPackingFormat;
}

}  // namespace

void save_packing(const std::filesystem::path& file, const SpherePacking& packing) {
  const H5Quiet quiet;
  // Session files also end in .h5, so a sphere packing may replace only files of sphere packings.
  if (std::error_code code; std::filesystem::is_regular_file(file, code) && !is_packing(file)) {
    throw Error(file.string(), "", "a file of another kind", "a packing to replace, or a new name");
  }
  PartialFile partial(file, FileKind::kSession);
  const H5 creation = without_times(H5P_FILE_CREATE);
  errno = 0;
  H5 h5(H5Fcreate(partial.path().c_str(), H5F_ACC_TRUNC, creation.get(), H5P_DEFAULT), H5Fclose);
  const auto refuse = [&] {
    throw Error(file.string(), "", errno ? std::strerror(errno) : h5_reason(),
                "a place where a packing can be written");
  };
  if (!h5) refuse();
  const hsize_t n = packing.size();
  const bool good =
      set_attribute(h5.get(), "format", kPackingFormat) && set_attribute(h5.get(), "format_version", kVersion) &&
      set_attribute(h5.get(), "seed", packing.seed) && set_attribute(h5.get(), "tissue_hash", packing.tissue_hash) &&
      set_attribute(h5.get(), "max_radius_m", packing.max_radius) &&
      set_attribute(h5.get(), "largest_hole_m", packing.max_hole) &&
      set_attribute(h5.get(), "checksum", checksum_of(packing)) &&
      write_array(h5.get(), "center_m", H5T_NATIVE_DOUBLE, n, 3, packing.center.data()) &&
      write_array(h5.get(), "radius_m", H5T_NATIVE_DOUBLE, n, 1, packing.radius.data()) &&
      write_array(h5.get(), "tissue", H5T_NATIVE_UINT8, n, 1, packing.tissue.data()) &&
      write_array(h5.get(), "solid_volume_m3", H5T_NATIVE_DOUBLE, kTissueCount, 1, packing.solid_volume.data());
  if (!good || !h5.reset()) refuse();
  partial.keep();
}

SpherePacking load_packing(const std::filesystem::path& file) {
  const H5Quiet quiet;
  const std::string path = file.string();
  std::error_code code;
  if (!std::filesystem::is_regular_file(file, code)) {
    throw Error(path, "", std::filesystem::exists(file, code) ? "no file" : "nothing", "a packing (.h5)");
  }
  H5 h5(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!h5) throw Error(path, "", fmt::format("no intact HDF5 file ({})", h5_reason()), "a packing (.h5)");
  std::string format, checksum;
  std::uint64_t version = 0;
  if (!get_attribute(h5.get(), "format", format) || format != kPackingFormat) {
    throw Error(path, "attribute \"format\"", format.empty() ? "nothing" : format.substr(0, 40), kPackingFormat);
  }
  if (!get_attribute(h5.get(), "format_version", version) || version != kVersion) {
    throw Error(path, "attribute \"format_version\"", std::to_string(version), std::to_string(kVersion));
  }
  SpherePacking p;
  if (!get_attribute(h5.get(), "seed", p.seed) || !get_attribute(h5.get(), "tissue_hash", p.tissue_hash) ||
      !get_attribute(h5.get(), "max_radius_m", p.max_radius) ||
      !get_attribute(h5.get(), "largest_hole_m", p.max_hole) || !get_attribute(h5.get(), "checksum", checksum)) {
    throw Error(path, "attributes", "one is missing", "seed, tissue_hash, max_radius_m, largest_hole_m, checksum");
  }
  static_assert(sizeof(dvec3) == 3 * sizeof(double) && sizeof(Tissue) == 1);
  const auto in = [](auto& numbers) {
    return [&numbers](std::size_t n) {
      numbers.resize(n);
      return numbers.data();
    };
  };
  read_array(h5.get(), path, "radius_m", H5T_FLOAT, H5T_NATIVE_DOUBLE, 0, 1, in(p.radius));
  read_array(h5.get(), path, "center_m", H5T_FLOAT, H5T_NATIVE_DOUBLE, p.size(), 3, in(p.center));
  read_array(h5.get(), path, "tissue", H5T_INTEGER, H5T_NATIVE_UINT8, p.size(), 1, in(p.tissue));
  read_array(h5.get(), path, "solid_volume_m3", H5T_FLOAT, H5T_NATIVE_DOUBLE, kTissueCount, 1,
             [&](std::size_t) { return p.solid_volume.data(); });
  if (const std::string found = checksum_of(p); found != checksum) {
    throw Error(path, "attribute \"checksum\"", found + " over the data",
                checksum.substr(0, 40) + " (the file is damaged)");
  }
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (!(p.radius[i] > 0) || !(p.radius[i] < 1) || !is_finite(p.center[i]) || p.tissue[i] == Tissue::kAir ||
        static_cast<int>(p.tissue[i]) >= kTissueCount) {
      throw Error(path, fmt::format("sphere {}", i),
                  fmt::format("radius {} m, tissue {}", p.radius[i], static_cast<int>(p.tissue[i])),
                  "a radius above 0, a finite centre and a tissue");
    }
  }
  return p;
}

}  // namespace typodont::session
