// What befalls the component in a scene; prints a line of what was drawn, warned of and left for each.
using System;
using System.IO;
using System.Linq;
using System.Reflection;
using UnityEngine;

static class Scenes
{
    static TextAsset manifest, uniform, tiles, regional, masked;
    static readonly Texture2D masks = new Texture2D { name = "regions" };
    static Shader shader;
    static Texture2D[] weights;
    static Mesh mesh;

    static void Main(string[] files)
    {
        Console.OutputEncoding = new System.Text.UTF8Encoding(false);
        manifest = new TextAsset { name = "manifest", text = File.ReadAllText(files[0]) };
        uniform = new TextAsset { name = "uniform", text = File.ReadAllText(files[1]) };
        tiles = new TextAsset { name = "tiles", text = File.ReadAllText(files[2]) };
        regional = new TextAsset { name = "regional", text = File.ReadAllText(files[3]) };
        masked = new TextAsset { name = "masked", text = File.ReadAllText(files[4]) };
        shader = new Shader();
        weights = new[] { new Texture2D { name = "weights_0" }, new Texture2D { name = "weights_1" } };
        mesh = new Mesh { name = "head", full = 100, shapes = File.ReadAllLines(files[5]) };
        Action<FaceZipHead>[] fields =
        {
            head => head.manifest = manifest,
            head => head.weightsShader = shader,
            head => head.weights = weights,
            head => head.beside.sharedMesh = mesh,
        };
        Show("all at once", Filled());
        foreach (int last in Enumerable.Range(0, fields.Length))
        {
            FaceZipHead head = Empty();
            for (int n = 1; n <= fields.Length; n++)
            {
                Frame(head);
                if (Graphics.Drawn.Count > 0) throw new Exception("it draws before all is there");
                fields[(last + n) % fields.Length](head);
            }
            Show("last " + last, head);
        }
        Changed("another manifest", head => head.manifest = uniform);
        Changed("another mesh", head => head.beside.sharedMesh = new Mesh { name = "ears", full = 1, shapes = new[] { mesh.shapes[1] } });
        Changed("another shader", head => head.weightsShader = new Shader());
        Changed("the manifest of all tiles", head => head.manifest = tiles);
        Changed("gains", head => Turn(head, 0.5f));
        Changed("gains of regions", head => { head.manifest = regional; head.regions = masks; Turn(head, 2); });
        Changed("a gain of nothing", head => { head.gains.regions["chin"] = 0; head.weightsShader = new Shader(); });
        Changed("regions without their image", head => head.manifest = regional);
        Changed("masks", head => { head.manifest = masked; head.weights = new[] { new Texture2D { name = "masks" } }; });
        Changed("masks without their image", head => { head.manifest = masked; head.weights = new Texture2D[0]; });
        Changed("disabled", head => Call(head, "OnDisable"));
    }

    static void Turn(FaceZipHead head, float gain)
    {
        head.gains.maps["albedo"] = gain;
        head.gains.expressions[mesh.shapes[0]] = 4;
        head.gains.expressions[mesh.shapes[0]] = gain;
        head.gains.regions["forehead"] = gain;
    }

    static FaceZipHead Empty()
    {
        var face = new SkinnedMeshRenderer();
        face.weights[0] = 25;
        face.weights[1] = 50;
        return new FaceZipHead { beside = face };
    }

    static FaceZipHead Filled()
    {
        FaceZipHead head = Empty();
        head.manifest = manifest;
        head.weightsShader = shader;
        head.weights = weights;
        head.beside.sharedMesh = mesh;
        return head;
    }

    static void Changed(string scene, Action<FaceZipHead> change)
    {
        FaceZipHead head = Filled();
        Frame(head);
        Graphics.Drawn.Clear();
        Debug.Warnings.Clear();
        change(head);
        Show(scene, head);
    }

    static void Show(string scene, FaceZipHead head)
    {
        if (scene != "disabled") { Frame(head); Graphics.Drawn.Clear(); Frame(head); }
        int alive = RenderTexture.Made.Count(texture => !texture.destroyed);
        string shown = string.Join(" ", head.beside.block.Textures.Where(entry => !entry.Value.destroyed).Select(entry => entry.Key));
        string gains = string.Join(" ", head.beside.block.Floats.Select(entry => entry.Key + " " + entry.Value));
        string[] parts = { scene, string.Join(";", Graphics.Drawn), shown, gains, alive.ToString(), string.Join(";", Debug.Warnings) };
        Console.WriteLine(string.Join("|", parts));
        RenderTexture.Made.Clear();
        Graphics.Drawn.Clear();
        Debug.Warnings.Clear();
    }

    static void Frame(FaceZipHead head) { Call(head, "LateUpdate"); }

    static void Call(FaceZipHead head, string method)
    {
        typeof(FaceZipHead).GetMethod(method, BindingFlags.Instance | BindingFlags.NonPublic).Invoke(head, null);
    }
}
