#include "engine/session/format/hdf5.h"

#include <algorithm>

namespace typodont::session {

namespace {

thread_local std::string t_reason;

/// Called by HDF5 for every failing call, while its error stack still stands (the next call clears it).
herr_t keep_reason(hid_t stack, void*) {
  // Downward: from the outermost call to the innermost, whose description names the cause.
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
  // At exit HDF5 would try to write what a full disk has refused, a hundred times, and then complain on standard error.
  // Sessions close their files themselves. It only listens before its first other call.
  static const bool no_exit_handler = H5dont_atexit() >= 0;
  static_cast<void>(no_exit_handler);
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

// HDF5 has no strings of length 0; one null byte is read back as "".
H5 h5_string_type(std::size_t size) {
  H5 type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.get(), std::max<std::size_t>(size, 1));
  H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  return type;
}

namespace {

bool plausible_string(hid_t type, std::size_t& size) {
  if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) > 0) return false;
  size = H5Tget_size(type);
  return size > 0 && size < (std::size_t{1} << 30);
}

void strip_padding(std::string& text) {
  while (!text.empty() && text.back() == '\0') text.pop_back();
}

bool set_scalar(hid_t object, const char* name, hid_t type, const void* value) {
  H5 space(H5Screate(H5S_SCALAR), H5Sclose);
  H5 attribute(H5Acreate2(object, name, type, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  return attribute && H5Awrite(attribute.get(), type, value) >= 0;
}

bool get_scalar(hid_t object, const char* name, H5T_class_t type_class, hid_t type, void* value) {
  if (H5Aexists(object, name) <= 0) return false;
  H5 attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  if (!attribute) return false;
  H5 space(H5Aget_space(attribute.get()), H5Sclose);
  H5 stored(H5Aget_type(attribute.get()), H5Tclose);
  if (H5Sget_simple_extent_npoints(space.get()) != 1 || H5Tget_class(stored.get()) != type_class) return false;
  return H5Aread(attribute.get(), type, value) >= 0;
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
  if (H5Aexists(object, name) <= 0) return false;
  H5 attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  if (!attribute) return false;
  H5 space(H5Aget_space(attribute.get()), H5Sclose);
  H5 stored(H5Aget_type(attribute.get()), H5Tclose);
  std::size_t size = 0;
  if (H5Sget_simple_extent_npoints(space.get()) != 1 || !plausible_string(stored.get(), size)) return false;
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
  H5 properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties.get(), false);  // equal sessions, equal bytes
  H5 dataset(H5Dcreate2(group, name, type.get(), space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT), H5Dclose);
  return dataset && H5Dwrite(dataset.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()) >= 0;
}

bool read_text(hid_t group, const char* name, std::string& text) {
  if (H5Lexists(group, name, H5P_DEFAULT) <= 0) return false;
  H5 dataset(H5Dopen2(group, name, H5P_DEFAULT), H5Dclose);
  if (!dataset) return false;
  H5 space(H5Dget_space(dataset.get()), H5Sclose);
  H5 stored(H5Dget_type(dataset.get()), H5Tclose);
  std::size_t size = 0;
  if (H5Sget_simple_extent_npoints(space.get()) != 1 || !plausible_string(stored.get(), size)) return false;
  H5 type = h5_string_type(size);
  std::string bytes(size, '\0');
  if (H5Dread(dataset.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()) < 0) return false;
  strip_padding(bytes);
  text = std::move(bytes);
  return true;
}

}  // namespace typodont::session
