# Doxygen reads only its own comments: this makes them of the ones in our headers.
1s|^/\* |/** \\file\n * |
1s|^// |/// \\file\n/// |
2,/^[^/]/s|^// |/// |
s|^( *)/\* ([^-])|\1/** \2|
s|(.*[^ /*].*[^ ]) +/\* (.*) \*/|\1 /**< \2 */|
s|^( *[^ /].*[;,{})]) +// |\1  ///< |
