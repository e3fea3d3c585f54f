// As much of Unity as the exported component uses, which remembers what was asked of it.
using System;
using System.Collections.Generic;

namespace UnityEngine
{
    public sealed class ExecuteAlways : Attribute { }
    public sealed class RequireComponent : Attribute { public RequireComponent(Type type) { } }
    public sealed class TooltipAttribute : Attribute { public TooltipAttribute(string text) { } }

    public enum FilterMode { Point, Bilinear, Trilinear }
    public enum TextureWrapMode { Repeat, Clamp }
    public enum RenderTextureFormat { ARGB32, ARGBHalf }
    public enum RenderTextureReadWrite { Default, Linear }
    [Flags] public enum HideFlags { None, HideAndDontSave = 61 }

    public class Object
    {
        public string name = "";
        public HideFlags hideFlags;
        public bool destroyed;
        public static void DestroyImmediate(Object thing) { thing.destroyed = true; }
        // A destroyed object counts as none.
        public static bool operator ==(Object one, Object other) { return ReferenceEquals(Live(one), Live(other)); }
        public static bool operator !=(Object one, Object other) { return !(one == other); }
        public override bool Equals(object other) { return this == other as Object; }
        public override int GetHashCode() { return 0; }
        static Object Live(Object thing) { return ReferenceEquals(thing, null) || thing.destroyed ? null : thing; }
    }

    public struct Vector4
    {
        public float x, y, z, w;
        public float this[int index]
        {
            get { return index == 0 ? x : index == 1 ? y : index == 2 ? z : w; }
            set { if (index == 0) x = value; else if (index == 1) y = value; else if (index == 2) z = value; else w = value; }
        }
        public static Vector4 operator +(Vector4 a, Vector4 b) { return new Vector4 { x = a.x + b.x, y = a.y + b.y, z = a.z + b.z, w = a.w + b.w }; }
        public static Vector4 operator *(float s, Vector4 a) { return new Vector4 { x = s * a.x, y = s * a.y, z = s * a.z, w = s * a.w }; }
    }

    public static class Mathf
    {
        public static float HalfToFloat(ushort half)
        {
            int exponent = (half >> 10) & 31, fraction = half & 1023;
            double value = exponent == 0 ? fraction * Math.Pow(2, -24) : (1024 + fraction) * Math.Pow(2, exponent - 25);
            return (float)(half >> 15 == 0 ? value : -value);
        }
    }

    public sealed class TextAsset : Object { public string text; }
    public sealed class Shader : Object { }
    public class Texture : Object { public FilterMode filterMode; public TextureWrapMode wrapMode; }
    public sealed class Texture2D : Texture { public static readonly Texture2D blackTexture = new Texture2D { name = "black" }; }

    public sealed class RenderTexture : Texture
    {
        public static readonly List<RenderTexture> Made = new List<RenderTexture>();
        public readonly int width, height;
        public bool useMipMap;
        public RenderTexture(int width, int height, int depth, RenderTextureFormat format, RenderTextureReadWrite mode)
        {
            this.width = width;
            this.height = height;
            Made.Add(this);
        }
    }

    public sealed class Mesh : Object
    {
        public string[] shapes;
        public float full;
        public int GetBlendShapeIndex(string shape) { return Array.IndexOf(shapes, shape); }
        public int GetBlendShapeFrameCount(int shape) { return 1; }
        public float GetBlendShapeFrameWeight(int shape, int frame) { return full; }
    }

    public sealed class MaterialPropertyBlock
    {
        public readonly Dictionary<string, Texture> Textures = new Dictionary<string, Texture>();
        public readonly SortedDictionary<string, float> Floats = new SortedDictionary<string, float>(StringComparer.Ordinal);
        public void SetTexture(string property, Texture texture) { Textures[property] = texture; }
        public void SetFloat(string property, float value) { Floats[property] = value; }
    }

    public sealed class Material : Object
    {
        public Shader shader;
        public readonly SortedDictionary<string, string> values = new SortedDictionary<string, string>(StringComparer.Ordinal);
        public Material(Shader shader) { this.shader = shader; }
        public void SetFloatArray(string property, float[] given)
        {
            values[property] = string.Join(" ", Array.ConvertAll(given, value => value.ToString("R")));
        }
        public void SetVectorArray(string property, Vector4[] given)
        {
            values[property] = string.Join(" ", Array.ConvertAll(given, v => string.Format("{0:R} {1:R} {2:R} {3:R}", v.x, v.y, v.z, v.w)));
        }
        public void SetTexture(string property, Texture texture) { values[property] = texture.name; }
    }

    public class Component : Object
    {
        public SkinnedMeshRenderer beside;
        public T GetComponent<T>() where T : class { return beside as T; }
    }

    public class MonoBehaviour : Component { }

    public sealed class SkinnedMeshRenderer : Component
    {
        public Mesh sharedMesh;
        public float[] weights = new float[8];
        public MaterialPropertyBlock block = new MaterialPropertyBlock();
        public float GetBlendShapeWeight(int shape) { return weights[shape]; }
        public void GetPropertyBlock(MaterialPropertyBlock block) { }
        public void GetPropertyBlock(MaterialPropertyBlock block, int material) { }
        public void SetPropertyBlock(MaterialPropertyBlock block) { this.block = block; }
        public void SetPropertyBlock(MaterialPropertyBlock block, int material) { this.block = block; }
    }

    public static class Graphics
    {
        public static readonly List<string> Drawn = new List<string>();
        public static void Blit(Texture source, RenderTexture target, Material material, int pass)
        {
            Drawn.Add(source.name + " " + target.width + "x" + target.height + " " + pass + " " + string.Join(" ", material.values.Values));
        }
    }

    public static class Debug
    {
        public static readonly List<string> Warnings = new List<string>();
        public static void LogWarning(object message, Object context) { Warnings.Add(message.ToString()); }
    }
}
