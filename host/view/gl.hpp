/// Owners of OpenGL objects. Each needs the context in which it was made to be current, at its end too.
#pragma once
#include <epoxy/gl.h>

#include <Eigen/Core>
#include <cstdint>
#include <initializer_list>
#include <span>

#include "host/view/camera.hpp"

namespace palpate::view::gl {

/// A vertex and a fragment shader, linked. Throws std::runtime_error with the driver's log.
class Program {
public:
    Program(const char* vertex_source, const char* fragment_source);
    ~Program();
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    void use() const { glUseProgram(id_); }
    /// Sets a uniform of the program in use.
    void set(const char* name, const Eigen::Matrix4f& value) const;
    void set(const char* name, const Eigen::Vector3f& value) const;
    void set(const char* name, const Eigen::Vector4f& value) const;
    void set(const char* name, float value) const;
    void set(const char* name, int value) const;

private:
    [[nodiscard]] GLint at(const char* name) const { return glGetUniformLocation(id_, name); }
    GLuint id_ = 0;
};

/// A vertex array with one vertex buffer and one index buffer.
class Vertices {
public:
    Vertices();
    ~Vertices();
    Vertices(const Vertices&) = delete;
    Vertices& operator=(const Vertices&) = delete;

    void bind() const;
    /// Replaces the content; grows when needed.
    void upload(const void* data, std::size_t n_bytes) const;
    /// Replaces the indices for glDrawElements.
    void upload_indices(std::span<const std::uint32_t> indices) const;
    /// Attribute `index`: `n_floats` floats at `offset_floats` of every `stride_floats`.
    void attribute(GLuint index, int n_floats, int stride_floats, int offset_floats) const;

private:
    GLuint array_ = 0;
    GLuint buffer_ = 0;
    GLuint indices_ = 0;
};

/// A texture of the given format; nearest, clamped.
class Texture {
public:
    Texture(Size size, GLint internal_format, GLenum format, GLenum type, const void* data);
    ~Texture();
    Texture(const Texture&) = delete;
    Texture& operator=(const Texture&) = delete;
    [[nodiscard]] GLuint id() const { return id_; }
    void bind(GLuint unit) const;

private:
    GLuint id_ = 0;
};

/// A framebuffer that draws into textures it does not own. Throws std::runtime_error when incomplete.
class Target {
public:
    Target(std::initializer_list<const Texture*> colours, const Texture* depth);
    ~Target();
    Target(const Target&) = delete;
    Target& operator=(const Target&) = delete;
    [[nodiscard]] GLuint id() const { return id_; }

private:
    GLuint id_ = 0;
};

}  // namespace palpate::view::gl
