#pragma once
// Errors of the second kind (STYLE.md section 5): bad data. Our own mistakes are FF_CHECKs, see check.h.

#include <cstdlib>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

namespace ff {

/// What kind of failure it was; the tool maps it to its exit code.
enum class ErrorKind {
    failure = 1,    ///< ours or the system's: disk full, no GL
    usage = 2,      ///< the command line
    bad_input = 3,  ///< a file that is not what it should be
    limit = 4,      ///< a budget or limit missed
};

/// A failure, said so that the reader can act: where, what was found, what was expected, what to do.
struct Error {
    ErrorKind kind = ErrorKind::failure;
    std::string message;  ///< `FILE:PLACE: found; expected ...; do ...`
};

[[nodiscard]] inline Error bad_input(std::string message) {
    return {ErrorKind::bad_input, std::move(message)};
}
[[nodiscard]] inline Error failure(std::string message) {
    return {ErrorKind::failure, std::move(message)};
}
[[nodiscard]] inline Error usage_error(std::string message) {
    return {ErrorKind::usage, std::move(message)};
}

/// A T, or why there is none. C++20 has no std::expected.
template <class T>
class [[nodiscard]] Result {
  public:
    Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
    Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

    explicit operator bool() const { return state_.index() == 0; }
    bool has_value() const { return state_.index() == 0; }
    T& value() & { return *checked(); }
    const T& value() const& { return *const_cast<Result*>(this)->checked(); }
    T&& value() && { return std::move(*checked()); }
    T& operator*() & { return *checked(); }
    const T& operator*() const& { return value(); }
    T&& operator*() && { return std::move(*checked()); }
    T* operator->() { return checked(); }
    const T* operator->() const { return &value(); }
    const Error& error() const { return *std::get_if<1>(&state_); }

  private:
    T* checked() {
        if (state_.index() != 0) std::abort();  // asked for a value without having looked
        return std::get_if<0>(&state_);
    }
    std::variant<T, Error> state_;
};

/// Success, or why not.
class [[nodiscard]] Status {
  public:
    Status() = default;
    Status(Error error) : error_(std::move(error)) {}
    explicit operator bool() const { return !error_.has_value(); }
    const Error& error() const { return *error_; }

  private:
    std::optional<Error> error_;
};

}  // namespace ff

/// Returns the error of a Result or Status to the caller.
#define FF_TRY(expression)                                                 \
    do {                                                                   \
        if (auto ff_try_ = (expression); !ff_try_) return ff_try_.error(); \
    } while (false)

/// Declares `target` as the value of a Result, or returns its error to the caller.
#define FF_ASSIGN_CONCAT2(a, b) a##b
#define FF_ASSIGN_CONCAT(a, b) FF_ASSIGN_CONCAT2(a, b)
#define FF_ASSIGN(target, expression) FF_ASSIGN_IMPL(FF_ASSIGN_CONCAT(ff_result_, __LINE__), target, expression)
#define FF_ASSIGN_IMPL(result, target, expression) \
    auto result = (expression);                    \
    if (!result) return result.error();            \
    target = std::move(*result)
