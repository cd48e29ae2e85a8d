// Callbacks that this program's file drivers for HDF5 have in common.
#pragma once

#include <hdf5.h>

#include <algorithm>
#include <cstdint>

namespace typodont::session {

/// Base of `File`, a file that HDF5 opened through a driver. HDF5 itself accesses only the first member. `Source`: the
/// object that use() passes to File::open(). File also defines kName, kFeatures, close, compare, get_eof, read and
/// write; flush() and truncate() do nothing unless File defines them.
template <class File, class Source>
struct DriverFile {
  H5FD_t hdf5{};
  Source* source = nullptr;
  haddr_t end_of_addresses = 0;

  static File& of(H5FD_t* file) { return static_cast<File&>(*reinterpret_cast<DriverFile*>(file)); }
  static const File& of(const H5FD_t* file) {
    return static_cast<const File&>(*reinterpret_cast<const DriverFile*>(file));
  }
  /// Null if the property list is of another driver.
  static Source* source_in(hid_t access) {
    const auto* source = static_cast<Source* const*>(H5Pget_driver_info(access));
    return source ? *source : nullptr;
  }
  /// Makes HDF5 use this driver for files that are opened with the property list `access`. False: HDF5 refuses.
  static bool use(hid_t access, Source* source) {
    static const H5FD_class_t kClass = driver_class();
    static const hid_t driver = H5FDregister(&kClass);
    return driver >= 0 && H5Pset_driver(access, driver, &source) >= 0;
  }

  static herr_t query(const H5FD_t*, unsigned long* flags) { return *flags = File::kFeatures, 0; }
  static haddr_t get_eoa(const H5FD_t* f, H5FD_mem_t) { return of(f).end_of_addresses; }
  static herr_t set_eoa(H5FD_t* f, H5FD_mem_t, haddr_t place) { return of(f).end_of_addresses = place, 0; }
  static herr_t flush(H5FD_t*, hid_t, hbool_t) { return 0; }
  static herr_t truncate(H5FD_t*, hid_t, hbool_t) { return 0; }
  // The drivers ignore HDF5's requests for locks, because recordings have their own lock (layout.h).
  static herr_t lock(H5FD_t*, hbool_t) { return 0; }
  static herr_t unlock(H5FD_t*) { return 0; }

 private:
  static H5FD_class_t driver_class() {
    H5FD_class_t c{};
    c.name = File::kName;
    c.maxaddr = static_cast<haddr_t>(INT64_MAX);
    c.fc_degree = H5F_CLOSE_STRONG;
    c.fapl_size = sizeof(Source*);
    c.open = File::open;
    c.close = File::close;
    c.cmp = File::compare;
    c.query = query;
    c.get_eoa = get_eoa;
    c.set_eoa = set_eoa;
    c.get_eof = File::get_eof;
    c.read = File::read;
    c.write = File::write;
    c.flush = File::flush;
    c.truncate = File::truncate;
    c.lock = lock;
    c.unlock = unlock;
    std::fill(std::begin(c.fl_map), std::end(c.fl_map), H5FD_MEM_DEFAULT);
    return c;
  }
};

}  // namespace typodont::session
