/* The part of Godot 3's binary interface (GDNative core 1.0, NativeScript 1.0) that this plugin uses. Debian has no
 * package with its headers. A function is identified by its index in the engine's tables. No release of Godot 3 changes
 * these tables: later versions append new tables through `next`. */
#ifndef TYPODONT_GODOT_GDNATIVE_H
#define TYPODONT_GODOT_GDNATIVE_H

#include <stdbool.h>
#include <stdint.h>

typedef void gd_object;
typedef struct {
  unsigned char opaque[24];
} gd_variant;
typedef struct {
  float x, y, z;
} gd_vector3;
/* Vectors that the engine returns. They are bytes, because a call passes bytes in other registers than floats. */
typedef struct {
  unsigned char bytes[12];
} gd_vector3_bytes;
typedef struct {
  unsigned char bytes[16];
} gd_quat_bytes; /* floats x y z w */
typedef struct {
  void* opaque;
} gd_handle; /* strings, arrays, pool arrays */

typedef struct gd_table {
  unsigned type, major, minor;
  const struct gd_table* next;
} gd_table;

typedef struct {
  gd_table head;
  unsigned extension_count;
  const gd_table** extensions;
  void (*function[744])(void);
} gd_core;

typedef struct {
  void* (*create)(gd_object*, void*);
  void* data;
  void (*free)(void*);
} gd_create;
typedef struct {
  void (*destroy)(gd_object*, void*, void*);
  void* data;
  void (*free)(void*);
} gd_destroy;
typedef struct {
  int rpc;
} gd_attributes;
typedef struct {
  gd_variant (*method)(gd_object*, void*, void*, int, gd_variant**);
  void* data;
  void (*free)(void*);
} gd_method;

typedef struct {
  gd_table head;
  void (*register_class)(void*, const char*, const char*, gd_create, gd_destroy);
  void (*register_tool_class)(void*, const char*, const char*, gd_create, gd_destroy);
  void (*register_method)(void*, const char*, const char*, gd_attributes, gd_method);
} gd_nativescript;
enum { GD_NATIVESCRIPT = 1 }; /* value of gd_table.type for NativeScript */

typedef struct {
  bool in_editor;
  uint64_t hashes[3];
  void* report_version_mismatch;
  void* report_loading_error;
  gd_object* library;
  const gd_core* core;
} gd_init_options;

/* Indices into gd_core.function, with the functions' types. */
#define GD(core, place, result, ...) ((result(*)(__VA_ARGS__))(core)->function[place])
#define gd_int_array_new(c, a) GD(c, 171, void, gd_handle*)(a)
#define gd_int_array_resize(c, a, n) GD(c, 180, void, gd_handle*, int)(a, n)
#define gd_int_array_write(c, a) GD(c, 182, void*, gd_handle*)(a)
#define gd_int_array_destroy(c, a) GD(c, 186, void, gd_handle*)(a)
#define gd_vector3_array_new(c, a) GD(c, 235, void, gd_handle*)(a)
#define gd_vector3_array_resize(c, a, n) GD(c, 244, void, gd_handle*, int)(a, n)
#define gd_vector3_array_write(c, a) GD(c, 246, void*, gd_handle*)(a)
#define gd_vector3_array_destroy(c, a) GD(c, 250, void, gd_handle*)(a)
#define gd_int_access(c, w) GD(c, 300, int*, const void*)(w)
#define gd_int_access_destroy(c, w) GD(c, 302, void, void*)(w)
#define gd_vector3_access(c, w) GD(c, 316, gd_vector3*, const void*)(w)
#define gd_vector3_access_destroy(c, w) GD(c, 318, void, void*)(w)
#define gd_array_new(c, a) GD(c, 323, void, gd_handle*)(a)
#define gd_array_append(c, a, v) GD(c, 336, void, gd_handle*, const gd_variant*)(a, v)
#define gd_array_destroy(c, a) GD(c, 361, void, gd_handle*)(a)
#define gd_variant_nil(c, v) GD(c, 509, void, gd_variant*)(v)
#define gd_variant_bool(c, v, b) GD(c, 510, void, gd_variant*, bool)(v, b)
#define gd_variant_real(c, v, r) GD(c, 513, void, gd_variant*, double)(v, r)
#define gd_variant_string(c, v, s) GD(c, 514, void, gd_variant*, const gd_handle*)(v, s)
#define gd_variant_vector3(c, v, p) GD(c, 517, void, gd_variant*, const gd_vector3*)(v, p)
#define gd_variant_array(c, v, a) GD(c, 529, void, gd_variant*, const gd_handle*)(v, a)
#define gd_variant_int_array(c, v, a) GD(c, 531, void, gd_variant*, const gd_handle*)(v, a)
#define gd_variant_vector3_array(c, v, a) GD(c, 535, void, gd_variant*, const gd_handle*)(v, a)
#define gd_as_real(c, v) GD(c, 540, double, const gd_variant*)(v)
#define gd_as_string(c, v) GD(c, 541, gd_handle, const gd_variant*)(v)
#define gd_as_vector3(c, v) GD(c, 544, gd_vector3_bytes, const gd_variant*)(v)
#define gd_as_quat(c, v) GD(c, 547, gd_quat_bytes, const gd_variant*)(v)
#define gd_variant_destroy(c, v) GD(c, 570, void, gd_variant*)(v)
#define gd_chars(c, s) GD(c, 572, const char*, const gd_handle*)(s)
#define gd_chars_destroy(c, s) GD(c, 573, void, gd_handle*)(s)
#define gd_string_utf8(c, s) GD(c, 678, gd_handle, const gd_handle*)(s)
#define gd_string_new(c, s) GD(c, 574, void, gd_handle*)(s)
#define gd_string_parse_utf8(c, s, t) GD(c, 679, bool, gd_handle*, const char*)(s, t)
#define gd_string_destroy(c, s) GD(c, 721, void, gd_handle*)(s)

#endif
