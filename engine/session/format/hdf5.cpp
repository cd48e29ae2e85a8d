#include "engine/session/format/hdf5.h"

#include <fmt/format.h>

#include <algorithm>

#include "engine/base/error.h"

namespace typodont::session {

namespace {

thread_local std::string t_reason;

/// Stores the reason of a failed call. Must be called at once, because the next call clears HDF5's error stack.
herr_t keep_reason(hid_t stack, void*) {
  // The innermost call, last in the stack, names the cause.
  H5Ewalk2(
      stack, H5E_WALK_DOWNWARD,
      [](unsigned, const H5E_error2_t* error, void*) -> herr_t {
        if (error->desc && *error->desc) t_reason = error->desc;
        return 0;
      },
      nullptr);
  return 0;
}

}  // namespace

H5Quiet::H5Quiet() {
  // At exit, HDF5 would repeat writes that failed on a full disk, and print errors. This must be the first call of
  // HDF5.
  static const bool no_exit_handler = H5dont_atexit() >= 0;
  static_cast<void>(no_exit_handler);
  // Forbids plugins: a file can name any filter, and HDF5 would load a plugin for it.
  static const bool no_plugins = H5PLset_loading_state(0) >= 0;
  static_cast<void>(no_plugins);
  H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
  H5Eset_auto2(H5E_DEFAULT, keep_reason, nullptr);
  t_reason.clear();
}
H5Quiet::~H5Quiet() {
  H5Eset_auto2(H5E_DEFAULT, function_, data_);
}

std::string h5_reason() {
  return t_reason.empty() ? "an unknown error of HDF5" : t_reason;
}

namespace {

constexpr hsize_t kMaxChunk = 16u << 20;             // bytes, largest size of a chunk
constexpr std::size_t kLongestAttribute = 1u << 20;  // bytes, largest length of an attribute

/// Opens the groups of the path one by one, because every name must be a hard link.
H5 open_object(const std::string& file, hid_t root, const std::string& path) {
  H5 at(H5Oopen(root, ".", H5P_DEFAULT), H5Oclose);
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    const std::string name = path.substr(begin, end - begin), so_far = path.substr(0, end);
    begin = end + 1;
    H5O_info_t object;
    if (!at || H5Oget_info2(at.get(), &object, H5O_INFO_BASIC) < 0 || object.type != H5O_TYPE_GROUP)
      throw Error(file, so_far, "something else on the way to it", "a group");
    if (H5Lexists(at.get(), name.c_str(), H5P_DEFAULT) <= 0) return {};
    H5L_info_t link;
    if (H5Lget_info(at.get(), name.c_str(), &link, H5P_DEFAULT) < 0)
      throw Error(file, so_far, h5_reason(), "a hard link");
    if (link.type == H5L_TYPE_SOFT) throw Error(file, so_far, "a soft link", "data inside the file");
    if (link.type != H5L_TYPE_HARD) throw Error(file, so_far, "a link to another file", "data inside the file");
    at = H5(H5Oopen(at.get(), name.c_str(), H5P_DEFAULT), H5Oclose);
    if (!at) throw Error(file, so_far, h5_reason(), "an intact file");
  }
  return at;
}

}  // namespace

H5 open_group(const std::string& file, hid_t root, const std::string& path) {
  H5 group = open_object(file, root, path);
  if (group && H5Iget_type(group.get()) != H5I_GROUP) throw Error(file, path, "something else", "a group");
  return group;
}

H5 open_dataset(const std::string& file, hid_t root, const std::string& path) {
  H5 dataset = open_object(file, root, path);
  if (!dataset) return dataset;
  if (H5Iget_type(dataset.get()) != H5I_DATASET) throw Error(file, path, "something else", "a dataset");
  const H5 properties(H5Dget_create_plist(dataset.get()), H5Pclose);
  if (!properties) throw Error(file, path, h5_reason(), "an intact file");
  if (H5Pget_external_count(properties.get()) != 0)
    throw Error(file, path, "data kept in another file", "data inside the file");
  const H5D_layout_t layout = H5Pget_layout(properties.get());
  if (layout != H5D_CHUNKED && layout != H5D_CONTIGUOUS && layout != H5D_COMPACT)
    throw Error(file, path, "a virtual dataset", "data inside the file");
  for (int i = 0; i < H5Pget_nfilters(properties.get()); ++i) {
    unsigned flags = 0;
    std::size_t values = 0;
    const H5Z_filter_t filter =
        H5Pget_filter2(properties.get(), static_cast<unsigned>(i), &flags, &values, nullptr, 0, nullptr, nullptr);
    if (filter != H5Z_FILTER_SHUFFLE && filter != H5Z_FILTER_DEFLATE && filter != H5Z_FILTER_FLETCHER32)
      throw Error(file, path, fmt::format("filter {}", filter), "shuffle, deflate or fletcher32");
  }
  // The size in the file's header must fit the file: otherwise a small damaged file could make the reader allocate much
  // memory.
  const H5 space(H5Dget_space(dataset.get()), H5Sclose), type(H5Dget_type(dataset.get()), H5Tclose);
  const hssize_t cells = H5Sget_simple_extent_npoints(space.get());
  const int dimensions = H5Sget_simple_extent_ndims(space.get());
  const std::size_t size = H5Tget_size(type.get());
  const H5 whole(H5Iget_file_id(dataset.get()), H5Fclose);
  hsize_t in_file = 0;
  if (cells < 0 || dimensions < 0 || dimensions > 1 || size == 0 || H5Fget_filesize(whole.get(), &in_file) < 0)
    throw Error(file, path, "another shape", "one row per entry");
  if (layout == H5D_CHUNKED) {
    hsize_t chunk = 0;
    if (H5Pget_chunk(properties.get(), 1, &chunk) != 1 || chunk == 0 || chunk > kMaxChunk / size)
      throw Error(file, path, "chunks of another size", fmt::format("chunks of up to {} bytes", kMaxChunk));
    if (H5Dget_storage_size(dataset.get()) > in_file)
      throw Error(file, path, "more bytes than the file has", "an intact file");
  } else if (static_cast<hsize_t>(cells) > in_file / size) {
    throw Error(file, path, "more bytes than the file has", "an intact file");
  }
  return dataset;
}

H5 without_times(hid_t kind) {
  H5 properties(H5Pcreate(kind), H5Pclose);
  H5Pset_obj_track_times(properties.get(), false);
  return properties;
}

H5 create_group(hid_t root, const std::string& path) {
  const H5 properties = without_times(H5P_GROUP_CREATE);
  return {H5Gcreate2(root, path.c_str(), H5P_DEFAULT, properties.get(), H5P_DEFAULT), H5Gclose};
}

hid_t h5_type(Type type) {
  switch (type) {
    case Type::kF64:
      return H5T_NATIVE_DOUBLE;
    case Type::kI64:
      return H5T_NATIVE_INT64;
    case Type::kU64:
      return H5T_NATIVE_UINT64;
    case Type::kU32:
      return H5T_NATIVE_UINT32;
    case Type::kU8:
      return H5T_NATIVE_UINT8;
  }
  return -1;
}

// HDF5 has no strings of length 0, so "" is stored as one null byte.
H5 h5_string_type(std::size_t size) {
  H5 type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.get(), std::max<std::size_t>(size, 1));
  H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  return type;
}

namespace {

bool plausible_string(hid_t type, std::size_t& size, std::size_t most) {
  if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) > 0) return false;
  size = H5Tget_size(type);
  return size > 0 && size <= most;
}

void strip_padding(std::string& text) {
  while (!text.empty() && text.back() == '\0') text.pop_back();
}

bool set_scalar(hid_t object, const char* name, hid_t type, const void* value) {
  H5 space(H5Screate(H5S_SCALAR), H5Sclose);
  H5 attribute(H5Acreate2(object, name, type, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  return attribute && H5Awrite(attribute.get(), type, value) >= 0;
}

/// Opens an attribute with one value; empty if it does not exist or has another shape.
H5 open_scalar(hid_t object, const char* name) {
  if (H5Aexists(object, name) <= 0) return {};
  H5 attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  if (!attribute) return {};
  const H5 space(H5Aget_space(attribute.get()), H5Sclose);
  return H5Sget_simple_extent_npoints(space.get()) == 1 ? std::move(attribute) : H5();
}

bool get_scalar(hid_t object, const char* name, H5T_class_t type_class, hid_t type, void* value) {
  const H5 attribute = open_scalar(object, name);
  if (!attribute) return false;
  const H5 stored(H5Aget_type(attribute.get()), H5Tclose);
  return H5Tget_class(stored.get()) == type_class && H5Aread(attribute.get(), type, value) >= 0;
}

}  // namespace

bool set_attribute(hid_t object, const char* name, std::string_view text) {
  std::string bytes(text);
  if (bytes.empty()) bytes.push_back('\0');
  H5 type = h5_string_type(bytes.size());
  return set_scalar(object, name, type.get(), bytes.data());
}
bool set_attribute(hid_t object, const char* name, double value) {
  return set_scalar(object, name, H5T_NATIVE_DOUBLE, &value);
}
bool set_attribute(hid_t object, const char* name, std::uint64_t value) {
  return set_scalar(object, name, H5T_NATIVE_UINT64, &value);
}

bool get_attribute(hid_t object, const char* name, std::string& text) {
  const H5 attribute = open_scalar(object, name);
  if (!attribute) return false;
  H5 stored(H5Aget_type(attribute.get()), H5Tclose);
  std::size_t size = 0;
  if (!plausible_string(stored.get(), size, kLongestAttribute)) return false;
  H5 type = h5_string_type(size);
  std::string bytes(size, '\0');
  if (H5Aread(attribute.get(), type.get(), bytes.data()) < 0) return false;
  strip_padding(bytes);
  text = std::move(bytes);
  return true;
}
bool get_attribute(hid_t object, const char* name, double& value) {
  return get_scalar(object, name, H5T_FLOAT, H5T_NATIVE_DOUBLE, &value);
}
bool get_attribute(hid_t object, const char* name, std::uint64_t& value) {
  return get_scalar(object, name, H5T_INTEGER, H5T_NATIVE_UINT64, &value);
}

bool write_text(hid_t group, const char* name, std::string_view text) {
  std::string bytes(text);
  if (bytes.empty()) bytes.push_back('\0');
  H5 type = h5_string_type(bytes.size());
  H5 space(H5Screate(H5S_SCALAR), H5Sclose);
  const H5 properties = without_times(H5P_DATASET_CREATE);
  H5 dataset(H5Dcreate2(group, name, type.get(), space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT), H5Dclose);
  return dataset && H5Dwrite(dataset.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()) >= 0;
}

bool read_text(const H5& dataset, std::string& text) {
  if (!dataset) return false;
  H5 space(H5Dget_space(dataset.get()), H5Sclose);
  H5 stored(H5Dget_type(dataset.get()), H5Tclose);
  std::size_t size = 0;
  // The length needs no limit here, because open_dataset() has compared it with the file's size.
  if (H5Sget_simple_extent_npoints(space.get()) != 1 || !plausible_string(stored.get(), size, SIZE_MAX)) return false;
  H5 type = h5_string_type(size);
  std::string bytes(size, '\0');
  if (H5Dread(dataset.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()) < 0) return false;
  strip_padding(bytes);
  text = std::move(bytes);
  return true;
}

}  // namespace typodont::session
