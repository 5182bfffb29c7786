#pragma once
// Whether a sanitizer that brings its own malloc is compiled in: GCC and clang tell in ways of their own.

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define FF_SANITIZES_MEMORY 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define FF_SANITIZES_MEMORY 1
#endif
#endif
