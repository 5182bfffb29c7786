#pragma once

#include <epoxy/gl.h>

#include <utility>

namespace ff::gl {

/// One GL name that is deleted with its owner; 0 is nothing. The context must be current wherever it is made or ends.
template <auto& Delete>
class Object {
  public:
    Object() = default;
    explicit Object(GLuint id) : id_(id) {}
    Object(Object&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
    Object& operator=(Object&& other) noexcept {
        std::swap(id_, other.id_);
        return *this;
    }
    ~Object() {
        if (id_ != 0) Delete(id_);
    }
    [[nodiscard]] GLuint id() const { return id_; }

  private:
    GLuint id_ = 0;
};

}  // namespace ff::gl
