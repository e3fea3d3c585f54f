// Unity's reader of JSON: public fields by their names, what has none is passed over, what is not there stays as it was.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Reflection;
using System.Text.RegularExpressions;

namespace UnityEngine
{
    public static class JsonUtility
    {
        public static T FromJson<T>(string text)
        {
            var words = new Queue<string>();
            foreach (Match word in Regex.Matches(text, @"""(?:[^""\\]|\\.)*""|[\[\]{}:,]|[^\s\[\]{}:,""]+")) words.Enqueue(word.Value);
            return (T)Read(words, typeof(T));
        }

        // With no type the value is passed over.
        static object Read(Queue<string> words, Type type)
        {
            string word = words.Dequeue();
            if (word == "{") return ReadObject(words, type);
            if (word == "[") return ReadArray(words, type == null || !type.IsArray ? null : type.GetElementType());
            if (type == typeof(string)) return Unquoted(word);
            if (type == typeof(int)) return int.Parse(word, CultureInfo.InvariantCulture);
            return null;
        }

        static object ReadObject(Queue<string> words, Type type)
        {
            object made = type == null ? null : Activator.CreateInstance(type, true);
            for (; words.Peek() != "}"; Skip(words, ","))
            {
                string name = Unquoted(words.Dequeue());
                Skip(words, ":");
                FieldInfo field = type == null ? null : type.GetField(name);
                object value = Read(words, field == null ? null : field.FieldType);
                if (field != null) field.SetValue(made, value);
            }
            words.Dequeue();
            return made;
        }

        static object ReadArray(Queue<string> words, Type type)
        {
            var values = new List<object>();
            for (; words.Peek() != "]"; Skip(words, ",")) values.Add(Read(words, type));
            words.Dequeue();
            if (type == null) return null;
            Array array = Array.CreateInstance(type, values.Count);
            for (int n = 0; n < values.Count; n++) array.SetValue(values[n], n);
            return array;
        }

        static void Skip(Queue<string> words, string word)
        {
            if (words.Peek() == word) words.Dequeue();
        }

        static string Unquoted(string word)
        {
            string text = word.Substring(1, word.Length - 2);
            return Regex.Replace(text, @"\\(u....|.)", found => found.Groups[1].Length == 1
                ? found.Groups[1].Value
                : ((char)int.Parse(found.Groups[1].Value.Substring(1), NumberStyles.HexNumber)).ToString());
        }
    }
}
