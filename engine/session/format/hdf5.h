// Wrappers for the part of the HDF5 library that sessions use: handles that close themselves, and the reasons of
// failures.
#pragma once

#include <hdf5.h>

#include <string>
#include <string_view>
#include <utility>

#include "engine/session/format/columns.h"

namespace typodont::session {

/// Owns one HDF5 identifier.
class H5 {
 public:
  using Close = herr_t (*)(hid_t);
  H5() = default;
  H5(hid_t id, Close close) : id_(id), close_(close) {}
  H5(H5&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  H5& operator=(H5&& other) noexcept {
    if (this != &other) {
      reset();
      id_ = std::exchange(other.id_, -1);
      close_ = other.close_;
    }
    return *this;
  }
  ~H5() { reset(); }
  /// Closes the identifier. Returns false if HDF5 fails to close it, for example because buffered data could not be
  /// written.
  bool reset() noexcept {
    const hid_t id = std::exchange(id_, -1);
    return id < 0 || close_(id) >= 0;
  }
  hid_t get() const { return id_; }
  explicit operator bool() const { return id_ >= 0; }

 private:
  hid_t id_ = -1;
  Close close_ = nullptr;
};

/// While this object exists, HDF5 prints no errors in this thread. h5_reason() returns the last error instead.
class H5Quiet {
 public:
  H5Quiet();
  ~H5Quiet();
  H5Quiet(const H5Quiet&) = delete;
  H5Quiet& operator=(const H5Quiet&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

/// Returns the reason of this thread's last HDF5 failure: the text of the innermost failed call. Needs an H5Quiet.
std::string h5_reason();

/// Opens a group or dataset by its path from `root`. Returns an empty handle if the object does not exist. Accepts only
/// objects that the session writer could have created: every name on the path is a hard link; a dataset has its data in
/// this file, uses the writer's filters, has one dimension, and states no more data than the file can contain. Other
/// links, external storage and virtual datasets are refused, because they could expose the content of other files.
/// Throws Error(`file`, path, …).
H5 open_group(const std::string& file, hid_t root, const std::string& path);
H5 open_dataset(const std::string& file, hid_t root, const std::string& path);

hid_t h5_type(Type type);
/// Makes a string type of fixed length (UTF-8, padded with null bytes).
H5 h5_string_type(std::size_t size);

// Functions that write and read attributes and texts. A function that writes returns false on failure. A function that
// reads returns false if the item does not exist or has another type.
bool set_attribute(hid_t object, const char* name, std::string_view text);
bool set_attribute(hid_t object, const char* name, double value);
bool set_attribute(hid_t object, const char* name, std::uint64_t value);
bool get_attribute(hid_t object, const char* name, std::string& text);
bool get_attribute(hid_t object, const char* name, double& value);
bool get_attribute(hid_t object, const char* name, std::uint64_t& value);
/// Writes a text of any length as a scalar dataset (UTF-8).
bool write_text(hid_t group, const char* name, std::string_view text);
/// Reads a text dataset. `dataset` is the result of open_dataset().
bool read_text(const H5& dataset, std::string& text);

}  // namespace typodont::session
